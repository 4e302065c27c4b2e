//! Parses unit labels such as `mm/s^2`, `(m/s²)/N`, `N*m*s/rad`, `kg·cm²` or `rpm`.

use thiserror::Error;

use super::dimension::Unit;
use super::symbol::{self, Reading};

/// Longest label (characters) and largest exponent that a unit can have.
const LONGEST: usize = 80;
const LARGEST_EXPONENT: i32 = 9;

/// Reason why a label is no unit.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UnitError {
    /// A symbol is unknown. Case counts: MN is a meganewton, mN a millinewton.
    #[error("the unit «{label}» is unknown{}", if symbol == label { String::new() } else { format!(" («{symbol}»)") })]
    Unknown {
        /// The label.
        label: String,
        /// The symbol.
        symbol: String,
    },
    /// A product follows a quotient without brackets.
    #[error("the unit «{label}» can mean two things; write brackets, as in (N/m)*s or N/(m*s)")]
    Ambiguous {
        /// The label.
        label: String,
    },
    /// Not a product of powers of symbols.
    #[error("«{label}» is no unit; write one like N/mm, m/s^2 or (m/s^2)/N")]
    Syntax {
        /// The label.
        label: String,
    },
}

/// Parses a label. «g» is the acceleration of free fall and «lb» a force.
///
/// # Errors  a symbol is unknown; the label is ambiguous or no unit.
pub fn parse(label: &str) -> Result<Unit, UnitError> {
    read(label, Reading::Vibration)
}

/// Parses a label where a certain quantity is expected: of the two meanings of «g», «mg» and «lb» the one
/// that `fits`.
///
/// # Errors  as [`parse`].
pub fn parse_for(label: &str, fits: impl Fn(Unit) -> bool) -> Result<Unit, UnitError> {
    let usual = parse(label)?;
    if fits(usual) {
        return Ok(usual);
    }
    Ok(read(label, Reading::Mass).ok().filter(|unit| fits(*unit)).unwrap_or(usual))
}

fn read(label: &str, reading: Reading) -> Result<Unit, UnitError> {
    let label = label.trim();
    let mut parser = Parser { label, characters: normalised(label), at: 0, reading };
    if parser.characters.len() > LONGEST || parser.characters.is_empty() {
        return Err(parser.syntax());
    }
    // Short for turns per minute, not for radians.
    if ["1/min", "/min", "min^-1", "min-1"].contains(&parser.characters.iter().collect::<String>().as_str()) {
        return parser.symbol("rpm", 1);
    }
    let unit = parser.product()?;
    let is_sound = parser.at == parser.characters.len() && unit.is_plausible();
    if is_sound { Ok(unit) } else { Err(parser.syntax()) }
}

/// Returns the characters of a label with one spelling of signs, exponents and brackets.
fn normalised(label: &str) -> Vec<char> {
    const SUPERSCRIPTS: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻";
    let mut characters = Vec::new();
    let mut is_raised = false;
    let spelled = label.replace("**", "^").replace(" per ", "/");
    for character in spelled.chars().take(LONGEST + 1) {
        let raised = SUPERSCRIPTS.chars().position(|c| c == character);
        if let Some(digit) = raised {
            if !is_raised {
                characters.push('^');
            }
            characters.push(char::from_digit(digit as u32, 10).unwrap_or('-'));
        } else {
            characters.push(match character {
                '·' | '⋅' | '×' | '•' => '*',
                'µ' | 'μ' => 'u',
                '−' | '–' => '-',
                '÷' | '∕' => '/',
                'º' => '°',
                '[' | '{' => '(',
                ']' | '}' => ')',
                other if other.is_whitespace() => ' ',
                other => other,
            });
        }
        is_raised = raised.is_some();
    }
    characters
}

struct Parser<'t> {
    label: &'t str,
    characters: Vec<char>,
    at: usize,
    reading: Reading,
}

impl Parser<'_> {
    fn syntax(&self) -> UnitError {
        UnitError::Syntax { label: self.label.chars().take(LONGEST).collect() }
    }

    fn peek(&self, ahead: usize) -> Option<char> {
        self.characters.get(self.at + ahead).copied()
    }

    fn skip_blanks(&mut self) {
        while self.peek(0) == Some(' ') {
            self.at += 1;
        }
    }

    /// Whether a point or a hyphen here joins two symbols, as in «N.m» and «ft-lbf».
    fn joins(&self) -> bool {
        matches!(self.peek(0), Some('.' | '-')) && self.peek(1).is_some_and(char::is_alphabetic)
    }

    /// Reads factors joined by products and quotients, up to a closing bracket or the end.
    fn product(&mut self) -> Result<Unit, UnitError> {
        let mut unit = Unit::ONE;
        let (mut is_first, mut is_divided) = (true, false);
        loop {
            self.skip_blanks();
            match self.peek(0) {
                None | Some(')') if is_first => return Err(self.syntax()),
                None | Some(')') => return Ok(unit),
                Some('.') if self.peek(1).is_none() => self.at += 1,
                Some('/') => {
                    self.at += 1;
                    unit = unit / self.factor()?;
                    is_divided = true;
                }
                Some(_) if is_divided => return Err(UnitError::Ambiguous { label: self.label.into() }),
                Some(sign) => {
                    if !is_first && (sign == '*' || self.joins()) {
                        self.at += 1;
                    }
                    unit = unit * self.factor()?;
                }
            }
            is_first = false;
        }
    }

    /// Reads a bracket, a number or a symbol, with its exponent.
    fn factor(&mut self) -> Result<Unit, UnitError> {
        self.skip_blanks();
        let start = self.at;
        match self.peek(0) {
            Some('(') => {
                self.at += 1;
                let unit = self.product()?;
                if self.peek(0) != Some(')') {
                    return Err(self.syntax());
                }
                self.at += 1;
                Ok(unit.power(self.exponent()?))
            }
            Some(digit) if digit.is_ascii_digit() => {
                while self.peek(0).is_some_and(|c| {
                    c.is_ascii_digit() || (c == '.' && self.peek(1).is_some_and(|d| d.is_ascii_digit()))
                }) {
                    self.at += 1;
                }
                if matches!(self.peek(0), Some('e' | 'E'))
                    && self.peek(1).is_some_and(|c| c.is_ascii_digit() || c == '-')
                {
                    self.at += 2;
                    while self.peek(0).is_some_and(|c| c.is_ascii_digit()) {
                        self.at += 1;
                    }
                }
                let number: String = self.characters[start..self.at].iter().collect();
                let number: f64 = number.parse().map_err(|_| self.syntax())?;
                Ok(Unit { factor: number, ..Unit::ONE }.power(self.exponent()?))
            }
            Some('-') if self.characters.len() == 1 => {
                self.at += 1;
                Ok(Unit::ONE)
            }
            _ => {
                let is_symbol = |c: char| (c.is_alphabetic() && c != '^') || "°%_'\"".contains(c);
                while self.peek(0).is_some_and(is_symbol) {
                    self.at += 1;
                }
                if self.at == start {
                    return Err(self.syntax());
                }
                let symbol: String = self.characters[start..self.at].iter().collect();
                let exponent = self.exponent()?;
                self.symbol(&symbol, exponent)
            }
        }
    }

    fn symbol(&self, symbol: &str, exponent: i32) -> Result<Unit, UnitError> {
        let unknown = || UnitError::Unknown { label: self.label.into(), symbol: symbol.into() };
        let (head, last) = symbol::units(symbol, self.reading).ok_or_else(unknown)?;
        Ok(head * last.power(exponent))
    }

    /// Reads an exponent: `^2`, `^-1`, `^(-1)`, `2`, `-1`; 1 where there is none.
    fn exponent(&mut self) -> Result<i32, UnitError> {
        let raised = self.peek(0) == Some('^');
        let start = self.at + usize::from(raised);
        let bracket = raised && self.characters.get(start) == Some(&'(');
        let mut at = start + usize::from(bracket);
        let sign = match self.characters.get(at) {
            Some('-') => -1,
            Some('+') if raised => 1,
            _ => 0,
        };
        at += usize::from(sign != 0);
        let digits: String = self.characters[at.min(self.characters.len())..]
            .iter()
            .take_while(|c| c.is_ascii_digit())
            .collect();
        if digits.is_empty() {
            return if raised { Err(self.syntax()) } else { Ok(1) };
        }
        at += digits.len();
        if bracket && self.characters.get(at) != Some(&')') {
            return Err(self.syntax());
        }
        self.at = at + usize::from(bracket);
        let size = digits
            .parse::<i32>()
            .ok()
            .filter(|size| *size <= LARGEST_EXPONENT)
            .ok_or_else(|| self.syntax())?;
        Ok(if sign < 0 { -size } else { size })
    }
}

#[cfg(test)]
mod tests {
    use super::super::dimension::Dimension;
    use super::*;

    fn si(label: &str) -> f64 {
        parse(label).unwrap_or_else(|fault| panic!("{label}: {fault}")).to_si()
    }

    #[test]
    fn limit_labels_have_the_factors_of_their_definitions() {
        let newton_per_pound = 4.448_221_615_260_5;
        for (label, expected) in [
            ("m", 1.0),
            ("mm/s^2", 1e-3),
            ("mm/s²", 1e-3),
            ("mm/s**2", 1e-3),
            ("m/s/s", 1.0),
            ("m s⁻²", 1.0),
            ("m.s-2", 1.0),
            ("m/sec2", 1.0),
            ("g", 9.806_65),
            ("Gs", 9.806_65),
            ("g_n", 9.806_65),
            ("gn", 9.806_65),
            ("mg", 9.806_65e-3),
            ("in/sec^2", 0.0254),
            ("mil", 2.54e-5),
            ("lbf", newton_per_pound),
            ("lbs", newton_per_pound),
            ("kip", 1e3 * newton_per_pound),
            ("MN", 1e6),
            ("mN", 1e-3),
            ("N/um", 1e6),
            ("N/µm", 1e6),
            ("N/mm", 1e3),
            ("kN/m", 1e3),
            ("kg·cm²", 1e-4),
            ("kgcm^2", 1e-4),
            ("kg*m2", 1.0),
            ("deg/s", std::f64::consts::PI / 180.0),
            ("rpm", std::f64::consts::TAU / 60.0),
            ("mm/rev", 1e-3 / std::f64::consts::TAU),
            ("Nm", 1.0),
            ("kNm", 1e3),
            ("Nmm/rad", 1e-3),
            ("ft-lbf", 0.3048 * newton_per_pound),
            ("(m/s^2)/N", 1.0),
            ("(1/N)*(m/s)", 1.0),
            ("[mm/s]/kN", 1e-6),
            ("Millimeters", 1e-3),
            ("meters per second", 1.0),
            ("%", 0.01),
            ("1", 1.0),
            ("-", 1.0),
            ("1e-6 m/N", 1e-6),
            ("GPa", 1e9),
        ] {
            assert!((si(label) / expected - 1.0).abs() < 1e-12, "{label}: {} {expected}", si(label));
        }
    }

    #[test]
    fn frequencies_convert_to_hz_exactly() {
        for (label, expected) in [
            ("Hz", 1.0),
            ("kHz", 1e3),
            ("1/s", 1.0),
            ("rpm", 1.0 / 60.0),
            ("1/min", 1.0 / 60.0),
            ("cpm", 1.0 / 60.0),
        ] {
            assert_eq!(parse(label).unwrap().to_hz(), Some(expected), "{label}");
        }
        assert_eq!(parse("rad/s").unwrap().to_hz(), Some(1.0 / std::f64::consts::TAU));
        for label in ["s", "m", "rad/s^2", "N"] {
            assert_eq!(parse(label).unwrap().to_hz(), None, "{label}");
        }
        let hz = parse("Hz").unwrap();
        assert_eq!(parse("rpm").unwrap().to(hz), Some(1.0 / 60.0));
        assert!((hz.to(parse("rad/s").unwrap()).unwrap() - std::f64::consts::TAU).abs() < 1e-15);
        assert_eq!(hz.to(parse("s").unwrap()), None);
    }

    #[test]
    fn a_symbol_with_two_meanings_takes_the_one_that_fits() {
        let inertia = |unit: Unit| unit.dimension == Dimension::mechanical(2, 1, 0);
        assert!((parse_for("g*cm^2", inertia).unwrap().to_si() - 1e-7).abs() < 1e-20);
        assert!(
            (parse_for("lb*in^2", inertia).unwrap().to_si() - 0.453_592_37 * 0.0254 * 0.0254).abs() < 1e-15
        );
        assert_eq!(parse("lb/in").unwrap().dimension, Dimension::mechanical(0, 1, -2));
        assert_eq!(parse("g").unwrap().dimension.name(), "an acceleration");
        assert_eq!(parse("V").unwrap().dimension.name(), "a voltage");
    }

    #[test]
    fn refuse_what_is_no_unit() {
        for label in ["bananas", "n", "MM/S2", "m/parsec", "order", "EU", "counts"] {
            assert!(matches!(parse(label), Err(UnitError::Unknown { .. })), "{label}: {:?}", parse(label));
        }
        for label in ["N/m*s", "N/m s", "m/s N"] {
            assert!(matches!(parse(label), Err(UnitError::Ambiguous { .. })), "{label}: {:?}", parse(label));
        }
        for label in [
            "",
            " ",
            "(m",
            "m)",
            "m^",
            "m^x",
            "m^99",
            "0 m",
            "m//s",
            "*",
            "^2",
            "((((((((((m^9)^9)^9)^9)^9)^9)^9)^9)^9)^9)",
            "(1e300 m)^2",
            &"m".repeat(200),
            &"(".repeat(70),
        ] {
            assert!(parse(label).is_err(), "{label}: {:?}", parse(label));
        }
    }
}
