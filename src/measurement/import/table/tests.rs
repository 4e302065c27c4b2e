use super::*;

fn read(text: &str) -> Result<Vec<ImportedFrf>, MeasurementError> {
    frfs_from_table(
        "a.csv",
        "a",
        text,
        &TableRequest { quantity: Some(Quantity::Receptance), ..TableRequest::default() },
    )
}

fn one(text: &str) -> ImportedFrf {
    let mut frfs = read(text).unwrap_or_else(|fault| panic!("{text}: {fault}"));
    assert_eq!(frfs.len(), 1, "{text}");
    frfs.remove(0)
}

fn refusal(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[test]
fn all_forms_of_a_value_agree() {
    let truth = Complex64::new(0.0, -2.0);
    for text in [
        "Frequency (Hz),Real,Imag\n0,1,0\n10,0,-2\n",
        "freq;mag;phase [deg];coherence\n10;2;-90;0.99\n",
        "freq;mag;phase [deg];coherence (%)\n10;2;-90;99\n",
        "freq\tmag\tphase_rad\n10\t2\t-1,5707963267948966\n20\t2,0\t-1,5707963267948966\n",
        "f;re;im\n10,0;0,0;-2,0\n",
        "f re im\n10 0 -2\n",
        "\u{feff}f,re,im\r\n10,0,-2\r\n",
        "Analyser 7\nDate,2020-01-01\n\nFrequency,Real,Imag\nHz,m/N,m/N\n10,0,-2\n11,0,-2\n",
        "# measured\n# f re im\n10 0 -2\n",
        "frequency_rad_s,real,imag\n62.83185307179586,0,-2\n",
        "freq_khz,real,imag\n0.01,0,-2\n",
        "f (rpm),Real (mm/N),Imag (m/N)\n600,0,-2\n",
        "f,mag (dB re 1 m/N),phase_deg\n10,6.020599913279624,-90\n",
        "f,mag (dB),phase_deg\n10,6.020599913279624,-90\n",
        "f (Hz),Real (N/m),Imag (N/m)\n10,0,0.5\n",
        "f,re,im,mag,phase_deg\n10,0,-2,2,-90\n",
    ] {
        let frf = one(text);
        assert!((frf.frequency_hz[0] - 10.0).abs() < 1e-9, "{text}: {:?}", frf.frequency_hz);
        assert!((frf.values[0] - truth).norm() < 1e-12, "{text}: {:?}", frf.values);
        assert!(frf.coherence.as_ref().is_none_or(|c| c == &[0.99]), "{text}");
    }
    assert!(one("f,mag (dB),phase_deg\n10,6,-90\n").warnings[0].contains("one SI unit"));
}

#[test]
fn several_frfs_in_one_table_are_all_imported() {
    for text in [
        "Frequency (Hz),Real 1,Imag 1,Real 2,Imag 2\n10,1,2,3,4\n",
        "Frequency (Hz),p1 real (m/N),p1 imag (m/N),p2 real (m/N),p2 imag (m/N)\n10,1,2,3,4\n",
        "f,re,im,re,im\n10,1,2,3,4\n",
        "f 1,re 1,im 1,f 2,re 2,im 2\n10,1,2,10,3,4\n",
    ] {
        let frfs = read(text).unwrap_or_else(|fault| panic!("{text}: {fault}"));
        let values: Vec<_> = frfs.iter().map(|f| f.values[0]).collect();
        assert_eq!(values, [Complex64::new(1.0, 2.0), Complex64::new(3.0, 4.0)], "{text}");
        assert_ne!(frfs[0].name, frfs[1].name);
    }
    assert!(refusal("f,re,im,remark\n1,1,1,1\n").contains("«remark»"));
    assert!(refusal("f,re 1,im 1,re 2\n1,1,1,1\n").contains("«2»"));
    assert!(refusal("f,re 1,im 1,re 2,im 2,coherence\n1,1,1,1,1,1\n").contains("left over"));
    assert!(refusal("f,f 2,re 1,im 1\n1,1,1,1\n").contains("several frequency columns"));
}

#[test]
fn units_of_each_column_are_applied_or_refused() {
    let frf = one("freq (kHz),real (mm/N),imag (mm/N)\n1,2,0\n");
    assert_eq!((frf.frequency_hz[0], frf.values[0].re), (1000.0, 2e-3));
    assert!(frf.warnings.is_empty(), "{:?}", frf.warnings);
    assert_eq!(one("f,real (mm/N),imag (um/N)\n1,1,1\n").values[0], Complex64::new(1e-3, 1e-6));
    assert!(refusal("f (Hz),real (furlong),imag\n1,1,0\n").contains("furlong"));
    assert!(refusal("f (Hz),real (g),imag (g)\n1,1,0\n").contains("an acceleration"));
    assert!(refusal("f (Hz),real ((m/s^2)/N),imag\n1,1,0\n").contains("set the quantity to accelerance"));
    assert!(refusal("f (parsec),re,im\n1,1,0\n").contains("kHz"));
    assert!(refusal("f (s),re,im\n1,1,0\n").contains("a time"));
    assert!(refusal("f,mag,phase\n1,1,1\n").contains("phase_deg"));
    assert!(refusal("f,mag,phase (m)\n1,1,1\n").contains("no angle"));
    assert!(refusal("time (s),re,im\n1,1,1\n").contains("time"));
}

#[test]
fn a_missing_value_costs_its_line_alone() {
    let frf = one("f,re,im\n0,NaN,NaN\n1,1,1\n2,********,1\n3,1,1\n");
    assert_eq!((frf.frequency_hz.as_slice(), frf.dropped), ([1.0, 3.0].as_slice(), 2));
    assert!(frf.warnings.iter().any(|w| w.contains("at 2 Hz")), "{:?}", frf.warnings);
    let strict =
        TableRequest { quantity: Some(Quantity::Receptance), strict: true, ..TableRequest::default() };
    assert!(
        frfs_from_table("a.csv", "a", "f,re,im\n1,NaN,1\n2,1,1\n", &strict)
            .unwrap_err()
            .to_string()
            .contains("not finite")
    );
    let clamped = one("f,re,im,coherence\n1,1,1,1.00001\n");
    assert_eq!(clamped.coherence, Some(vec![1.0]));
    assert!(clamped.warnings.iter().any(|w| w.contains("taken as 0 or 1")), "{:?}", clamped.warnings);
    assert_eq!(one("f,re,im,coherence\n1,1,1,1.5\n").coherence, None);
}

#[test]
fn lines_may_end_in_a_separator() {
    let frf = one("f,re,im,\n1,1,2,\n2,3,4,\n");
    assert_eq!(frf.values, [Complex64::new(1.0, 2.0), Complex64::new(3.0, 4.0)]);
    assert!(refusal("f,re,im,\n1,1,2,\n2,3,4,5\n").contains("the column without a name holds «5»"));
    assert!(refusal("f,,re,im\n1,1,2,3\n").contains("no known meaning"));
}

#[test]
fn columns_of_different_quantities_are_named_in_words() {
    let text = refusal("f (Hz),re (g/N),im (m/N)\n1,1,1\n");
    assert!(text.contains("accelerance and receptance") && !text.contains("Ratio"), "{text}");
    assert!(refusal("f (Hz),re (\u{1b}[31m/N),im (m/N)\n1,1,1\n").contains("no unit"));
}

/// All of several thousand FRFs in one table are found.
#[test]
fn limit_many_columns() {
    let count = 20_000;
    let header: String = (0..count).map(|at| format!(",re {at} (m/N),im {at} (m/N)")).collect();
    let line = |f: u32| format!("{f}{}\n", ",1,2".repeat(count));
    let text = format!("f (Hz){header}\n{}{}", line(1), line(2));
    assert_eq!(frfs_from_table("a.csv", "a", &text, &TableRequest::default()).unwrap().len(), count);
}

#[test]
fn refuse_what_is_no_table() {
    assert!(refusal("f,re,im\n1,1,1\n1.5,x,1\n").contains("line 3"));
    assert!(refusal("f,re,im\n1,1,1\n2,1\n").contains("line 3"));
    assert!(refusal("f,mag,phase_deg\n1,-1,0\n").contains("line 2"));
    assert!(refusal("1,1,1\n2,1,1\n").contains("name its columns"));
    assert!(refusal("").contains("empty"));
    let named = TableRequest {
        columns: Some(["f", "re", "im"].map(String::from).to_vec()),
        quantity: Some(Quantity::Receptance),
        strict: false,
    };
    assert_eq!(frfs_from_table("a.dat", "a", "1,1,1\n2,1,1\n", &named).unwrap()[0].frequency_hz, [1.0, 2.0]);
    assert!(
        frfs_from_table("a.dat", "a", "1,1\n2,1\n", &named)
            .unwrap_err()
            .to_string()
            .contains("the table has 2")
    );
    // Names that contradict the header; one that says the same otherwise is no contradiction.
    let turned =
        frfs_from_table("a.dat", "a", "frequency_hz,imag,real\n1,1,1\n", &named).unwrap_err().to_string();
    assert!(turned.contains("the column «imag» of the header is named re"), "{turned}");
    frfs_from_table("a.dat", "a", "Frequency (Hz);Real;Imaginary\n1;1;1\n", &named).unwrap();
    let no_quantity = frfs_from_table("a.csv", "a", "f,re,im\n1,1,1\n", &TableRequest::default());
    assert!(no_quantity.unwrap_err().to_string().contains("set the quantity"));
}
