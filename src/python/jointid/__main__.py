"""`python -m jointid` is the command `jointid`."""

import sys

from ._command import main

sys.exit(main())
