//! `jointid import` and `jointid export`: measurement sets from and to files of other programs.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::arguments::QUANTITIES;
use crate::message::{shown, to_message};
use crate::outcome::{CommandResult, Outcome, named_file, prepare_file, print_out};
use crate::terminal;
use crate::words::one_of;
use report::{Existing, OutputFolder, wrapped};
use study::{ImportRequest, Quantity, read_set};

/// Arguments of `import`.
#[derive(Debug, clap::Args)]
pub struct ImportArguments {
    /// Universal files (dataset 58, 58b) or tables (.csv, .tsv, .txt, .dat, .asc)
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Folder of the new measurement set
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// List the contents of the files from their headers, and write nothing
    #[arg(long)]
    pub list: bool,
    /// Replace the measurement set in the folder
    #[arg(long)]
    pub replace: bool,
    /// Refuse a file with any faulty part, instead of importing its sound parts
    #[arg(long)]
    pub strict: bool,
    /// Columns of tables without header, in their order, e.g. frequency_hz,real,imag
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Accept files that end inside their data
    #[arg(long)]
    pub accept_truncated: bool,
    /// Measured quantity, where the files do not state it
    #[arg(long, value_parser = one_of(&QUANTITIES))]
    pub quantity: Option<Quantity>,
    /// Position of all records
    #[arg(long, value_name = "NAME")]
    pub position: Option<String>,
    /// Pattern with {} for the position's name, in file names, ID lines or entities, e.g. 'pos {}'
    #[arg(long, value_name = "TEXT")]
    pub pattern: Option<String>,
    /// Table that assigns records, with the columns record,position,response,excitation
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Nut positions (m), comma-separated, e.g. l1=0.6,l2=1.3
    #[arg(long, value_name = "NAME=M", value_delimiter = ',')]
    pub nut_m: Vec<String>,
    /// Response point of all records
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Excitation point of all records
    #[arg(long, value_name = "POINT")]
    pub excitation: Option<String>,
    /// Number of averages of each FRF; required to use a coherence
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub averages: Option<u32>,
    /// Title of the set
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Print only results and errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct ExportArguments {
    /// Folder of the measurement set
    #[arg(long, value_name = "DIR")]
    pub measurements: String,
    /// File to write
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Write dataset 58b, binary, instead of text
    #[arg(long)]
    pub binary: bool,
    /// Replace an existing file
    #[arg(long)]
    pub replace: bool,
}

/// Imports files of other programs as a measurement set.
pub fn import(given: &ImportArguments) -> CommandResult {
    if given.list {
        return list(given);
    }
    let out = given
        .out
        .as_ref()
        .ok_or("import: name the folder of the new set with --out, or list the files with --list")?;
    let title =
        given.title.clone().or_else(|| out.file_name().map(|name| name.to_string_lossy().into_owned()));
    let request = ImportRequest {
        files: given.files.clone(),
        columns: (!given.columns.is_empty()).then(|| given.columns.clone()),
        strict: given.strict,
        accept_truncated: given.accept_truncated,
        quantity: given.quantity,
        position: given.position.clone(),
        pattern: given.pattern.clone(),
        map: given.map.clone(),
        nut_m: nut_positions(&given.nut_m)?,
        response: given.response.clone(),
        excitation: given.excitation.clone(),
        averages: given.averages,
        title: title.unwrap_or_else(|| "imported".into()),
    };
    let existing = if given.replace {
        Existing::Replaced
    } else {
        Existing::Kept("name an empty folder with --out, or replace the set in it with --replace")
    };
    // Checked before the files are read, which may take long.
    OutputFolder::prepare(out).and_then(|to| to.check(&["manifest.toml"], existing)).map_err(to_message)?;
    let imported = study::import(&request).map_err(shown)?;
    let folder = OutputFolder::claim(out).map_err(to_message)?;
    let left_behind = imported.left_behind(out);
    folder.write_all(imported.files(), existing).map_err(to_message)?;
    for path in left_behind {
        if let Err(error) = std::fs::remove_file(&path) {
            terminal::warning(&format!(
                "{}: a table of the replaced set cannot be removed: {error}",
                path.display()
            ));
        }
    }
    if !given.quiet {
        imported.notes.iter().for_each(|n| terminal::warning(n));
    }
    let (count, at_positions) = (imported.frfs(), imported.frfs_at_positions());
    let frfs = if count == 1 { "FRF" } else { "FRFs" };
    print_out(&format!(
        "{count} {frfs} imported into {}, {at_positions} of them at a position\n",
        out.display()
    ))?;
    Ok(Outcome::Done)
}

/// Lists the records of the files from their headers, one per line.
fn list(given: &ImportArguments) -> CommandResult {
    let mut text = String::new();
    for contents in study::list_contents(&given.files).map_err(shown)? {
        text += &contents.text;
        contents.warnings.iter().for_each(|w| text += &wrapped(&format!("  warning: {w}")));
    }
    print_out(&text)?;
    Ok(Outcome::Done)
}

fn nut_positions(given: &[String]) -> Result<BTreeMap<String, f64>, String> {
    let mut positions = BTreeMap::new();
    for text in given {
        let (name, number) =
            text.split_once('=').ok_or_else(|| format!("--nut-m {text}: write NAME=M, as in l1=0.6"))?;
        let nut_m = number.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let nut_m = nut_m.ok_or_else(|| format!("--nut-m {text}: «{number}» is no distance in m"))?;
        if let Some(other_m) = positions.insert(name.trim().to_string(), nut_m) {
            return Err(format!("--nut-m {text}: {} is at {other_m} m already; write one", name.trim()));
        }
    }
    Ok(positions)
}

/// Writes the FRFs of a set as a universal file.
pub fn export(given: &ExportArguments) -> CommandResult {
    let existing = named_file(given.replace);
    let (folder, name) = prepare_file((&given.out, "--out"), existing, (None, &[]))?;
    let set = read_set(&given.measurements).map_err(shown)?;
    let exported = study::export(&set, given.binary).map_err(shown)?;
    folder.write_all([(name, &exported.bytes)], existing).map_err(to_message)?;
    exported.notes.iter().for_each(|n| terminal::warning(n));
    print_out(&format!("{} FRFs written to {}\n", exported.frfs, given.out.display()))?;
    Ok(Outcome::Done)
}
