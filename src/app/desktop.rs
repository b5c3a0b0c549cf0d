//! What the desktop asks of programs: less motion, and dark or light where the window system does not tell.
//!
//! Asked with the desktop's own tools, on a thread, because none of them is quick: `gsettings` (GNOME and those that follow
//! its schema), `defaults` (macOS), `reg` (Windows). Where there is no such tool, there is no answer.

use std::process::{Command, Stdio};

/// The desktop's answers; absent where it has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Wishes {
    /// Less motion.
    pub(crate) reduced_motion: Option<bool>,
    /// Light and not dark.
    pub(crate) light: Option<bool>,
}

/// Asks, and tells the answer from another thread. Without a thread nobody answers.
pub(crate) fn ask(answer: impl FnOnce(Wishes) + Send + 'static) {
    let asked = std::thread::Builder::new().name("desktop".into()).spawn(move || answer(wishes()));
    if let Err(error) = asked {
        log::info!("the desktop's wishes are not known: no thread to ask on: {error}");
    }
}

fn wishes() -> Wishes {
    if cfg!(target_os = "macos") {
        let reduced = said("defaults", &["read", "com.apple.universalaccess", "reduceMotion"]);
        return Wishes { reduced_motion: reduced.as_deref().and_then(truth), light: None };
    }
    if cfg!(target_os = "windows") {
        let animate = said("reg", &["query", r"HKCU\Control Panel\Desktop\WindowMetrics", "/v", "MinAnimate"]);
        let shown = animate.as_deref().and_then(|text| text.split_whitespace().last()).and_then(truth);
        return Wishes { reduced_motion: shown.map(|shown| !shown), light: None };
    }
    let get = |key| said("gsettings", &["get", "org.gnome.desktop.interface", key]);
    let animations = get("enable-animations").as_deref().and_then(truth);
    let light = get("color-scheme").and_then(|scheme| match scheme.trim_matches('\'') {
        "prefer-light" => Some(true),
        "prefer-dark" => Some(false),
        _ => None,
    });
    Wishes { reduced_motion: animations.map(|animations| !animations), light }
}

/// What a program prints, where it is there and succeeds.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn truth(text: &str) -> Option<bool> {
    match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_clear_answers_count() {
        assert_eq!((truth("true"), truth("0"), truth(""), truth("maybe")), (Some(true), Some(false), None, None));
        assert_eq!(said("no-such-program-anywhere", &[]), None);
    }
}
