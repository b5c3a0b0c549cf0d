//! Comparison with stored ratios: those of another machine say whether something got slower, where milliseconds would not.

use std::collections::BTreeMap;
use std::path::Path;

use super::{Ratios, say};

/// A ratio this much below the stored one is called out.
const WORSE: f64 = 0.85;

/// Says which ratios fell against those stored for `adapter`, or stores these.
pub(super) fn compare(adapter: &str, ratios: &Ratios, table: &mut String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/baseline.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|_| "{}".into());
    let mut stored: BTreeMap<String, Ratios> = serde_json::from_str(&text).unwrap();
    if std::env::var_os("RELIEF_UPDATE_BASELINE").is_some() {
        let rounded = ratios.iter().map(|(name, ratio)| (name.clone(), (ratio * 1e3).round() / 1e3));
        stored.entry(adapter.to_owned()).or_default().extend(rounded);
        std::fs::write(&path, serde_json::to_string_pretty(&stored).unwrap() + "\n").unwrap();
        say(table, &format!("\nStored {} ratios as the baseline of {adapter}.", ratios.len()));
        return;
    }
    let Some(baseline) = stored.get(adapter) else {
        say(table, &format!("\nNo baseline for {adapter}: RELIEF_UPDATE_BASELINE=1 stores this run's."));
        return;
    };
    let known = ratios.iter().filter_map(|(name, &ratio)| Some((name, ratio, *baseline.get(name)?)));
    let (mut worse, mut count) = (0, 0);
    for (name, ratio, before) in known {
        count += 1;
        if ratio < WORSE * before {
            worse += 1;
            say(table, &format!("- slower than the baseline: {name}: {ratio:.2}, was {before:.2}"));
        }
    }
    say(table, &format!("\n{count} ratios compared with the baseline, {worse} of them below {WORSE} of it."));
}
