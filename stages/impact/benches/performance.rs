//! Speed of the solver beside the machine's own: `cargo bench -p hvi-impact` prints the table, `-- --write docs/performance.md`
//! writes it with its figure; `--large` adds 1e7 particles, `--quick` leaves out the longer runs, `--sweep` runs the eta sweep of
//! pipelines/copper.toml and nothing else. CPU time, on Linux only.
#[path = "performance/blocks.rs"]
mod blocks;
#[path = "performance/cpu.rs"]
mod cpu;
#[path = "performance/machine.rs"]
mod machine;
#[path = "performance/page.rs"]
mod page;
#[path = "performance/scenes.rs"]
mod scenes;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |name: &str| arguments.iter().any(|a| a == name);
    if has("--sweep") {
        return scenes::sweep();
    }
    let measured = page::Measured {
        machine: machine::measure(),
        methods: blocks::methods(),
        sizes: blocks::sizes(if has("--large") { &[1e4, 1e5, 1e6, 1e7] } else { &[1e4, 1e5, 1e6] }),
        threads: blocks::threads(),
        scenes: if has("--quick") { Vec::new() } else { scenes::yardstick() },
    };
    let text = page::text(&measured);
    println!("{text}");
    if let Some(at) = arguments.iter().position(|a| a == "--write") {
        // Benchmarks run in the folder of their crate.
        let path = std::path::Path::new("../..").join(arguments.get(at + 1).expect("a file after --write"));
        std::fs::write(&path, &text).expect("a folder that can be written to");
        let figure = path.with_file_name("pictures").join("performance.svg");
        std::fs::write(figure, page::figure(&measured.sizes)).expect("a folder that can be written to");
    }
}
