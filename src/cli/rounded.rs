//! Numbers for people: rounded to what they can mean. `--json` keeps every digit.

/// A height: at most two digits behind the point, more only for small numbers, and none that are zeros.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e9).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = if size == 0.0 || size >= 10.0 { 2 } else { (2.0 - size.log10().floor()).max(0.0) as usize };
    trimmed(format!("{value:.digits$}"))
}

/// Metres, or kilometres from ten on.
pub(crate) fn metres(value: f64) -> String {
    if value >= 10_000.0 { format!("{:.2} km", value / 1000.0) } else { format!("{} m", number(value)) }
}

/// A coordinate beside the one at the other end: digits that tell samples apart, and not those below.
pub(crate) fn place((value, other): (f64, f64)) -> String {
    let span = (value - other).abs().max(f64::MIN_POSITIVE);
    let digits = (5.0 - span.log10().floor()).clamp(0.0, 12.0) as usize;
    trimmed(format!("{value:.digits$}"))
}

/// Degrees to a metre or so.
pub(crate) fn degrees(value: f64) -> String {
    format!("{value:.5}")
}

fn trimmed(text: String) -> String {
    if !text.contains('.') {
        return text;
    }
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_what_they_can_mean() {
        for (value, expected) in [
            (0.0, "0"),
            (479.0, "479"),
            (380.750_000_000_000_06, "380.75"),
            (-100.5, "-100.5"),
            (1.234_567_8, "1.23"),
            (0.012_345, "0.0123"),
            (65535.0, "65535"),
            (-0.000_04, "-4.000e-5"),
            (1e30, "1.000e30"),
        ] {
            assert_eq!(number(value), expected);
        }
        assert_eq!(
            (metres(600.0), metres(31_566.9), metres(61.640_123)),
            ("600 m".into(), "31.57 km".into(), "61.64 m".into())
        );
        assert_eq!(place((-12_518_543.123_456_7, -12_479_480.9)), "-12518543.1");
        assert_eq!((place((7.0, 8.0)), place((-119.746_421_250_254_7, -118.7))), ("7".into(), "-119.74642".into()));
    }
}
