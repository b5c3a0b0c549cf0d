//! No usable adapter: exit 4.

use crate::bench::{Bench, run};

#[test]
fn without_an_adapter_the_driver_to_install_is_named() {
    let bench = Bench::new();
    for line in ["render -o out.png --size 8x8", ""] {
        let mut command = bench.command(line.split_whitespace());
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, "/nonexistent/driver.json");
        }
        let run = run(command.env_remove("VK_ADD_DRIVER_FILES"));
        run.expect(4, &["no usable GPU adapter", "mesa-vulkan-drivers", "apt-get"]).says_what_why_and_what_to_do();
    }
    assert!(bench.names().is_empty());
}
