//! Shaders that are read again when they are saved; debug builds only.

use std::fs;
use std::path::Path;

use crate::harness::{Window, differing, told};

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn a_broken_shader_is_told_and_a_good_one_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders"), folder.path());
    let file = folder.path().join("skybox.wgsl");
    let good = fs::read_to_string(&file).unwrap();
    let environment = [("RELIEF_SHADERS", folder.path().to_str().unwrap())];
    let mut window = Window::open_with("--size 640x480 --view horizon", &environment);
    let (_, before) = window.shot();

    fs::write(&file, format!("{good}\nthis is no shader\n")).unwrap();
    let told_so = window.settled("the compiler's message", |status| told(status, "The old shaders stay"));
    assert!(told(&told_so, "skybox.wgsl"), "the file is named: {}", told_so["toasts"]);
    let (_, broken) = window.shot();
    assert_eq!(differing(&before, &broken, 0), 0, "the old picture stays");

    let changed = good.replacen("return vec4f(root", "return vec4f(0.25 * root", 1);
    assert_ne!(changed, good, "the sky squares a root");
    fs::write(&file, changed).unwrap();
    window.settled("new shaders", |status| told(status, "Shaders reloaded"));
    let (_, darker) = window.shot();
    assert!(differing(&before, &darker, 20) > 5000, "the sky is darker now");
    window.close();
}
