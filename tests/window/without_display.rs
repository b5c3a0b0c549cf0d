//! Where there is no window system.

use crate::harness::relief;

#[test]
fn without_a_display_the_start_view_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = relief().current_dir(folder.path()).args(["--size", "320x200"]).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("no display") && stderr.contains("relief-view.png"), "{stderr}");
    let picture = image::open(folder.path().join("relief-view.png")).unwrap().to_rgba8();
    assert_eq!(picture.dimensions(), (320, 200));
    let colours: std::collections::HashSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 1000, "a terrain has many colours, this picture has {}", colours.len());
}
