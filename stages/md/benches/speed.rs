//! Time of one step per atom: `cargo bench -p hvi-md --bench speed`, or with `-- N` for N^3 cells. One core; CPU time, the least of
//! 25 slices (5 of large boxes, of which the crystal at rest volume alone is run), which is what a machine without other work
//! would take.
use hvi_md::lanes::Isa;
use hvi_md::units::BOLTZMANN;
use hvi_md::{Chain, Potential, System, Tables, lattice};

/// Cubic cells along the edge of a large box.
const LARGE: usize = 30;

fn main() {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let sizes = if sizes.is_empty() { vec![4, 5, 10] } else { sizes };
    println!("isa       atoms  V/V0     T  ns/atom/step  rebuilt every");
    for cells in sizes {
        let states = [(1.0, 300.0), (0.64, 300.0), (1.0, 5000.0), (0.64, 4500.0)];
        for &(ratio, temperature) in if cells < LARGE { &states[..] } else { &states[..1] } {
            // the portable lanes take a hundredfold; one small box tells
            for isa in Isa::all().into_iter().filter(|isa| isa.name() != "portable" || cells < 5) {
                measure(isa, cells, ratio, temperature);
            }
        }
    }
}

/// One line of the table.
fn measure(isa: Isa, cells: usize, ratio: f64, temperature: f64) {
    let potential = Potential::Mishin2001;
    let edge = lattice::edge(&potential, ratio).unwrap();
    let sites = lattice::sites(cells, edge);
    let mut system = System::new(Tables::new(potential), isa, &sites, edge * cells as f64).expect("a crystal");
    system.heat(2.0 * temperature, 1);
    let mut chain = Chain::new(BOLTZMANN * temperature, system.freedom(), 0.1);
    let slow = if isa.name() == "portable" { 20 } else { 1 };
    let steps = (80_000 / system.atoms() / slow).max(5);
    let mut run = |steps: usize| (0..steps).for_each(|_| system.advance(0.002, Some(&mut chain)).expect("it runs"));
    let (before, slices) = if cells < LARGE { (400, 25) } else { (30, 5) };
    run(if slow == 1 { before } else { steps });
    let mut times: Vec<f64> = (0..slices)
        .map(|_| {
            let start = cpu_time();
            run(steps);
            (cpu_time() - start) / (steps * sites.len()) as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let every = system.steps() as f64 / system.rebuilds() as f64;
    println!("{:9} {:5}  {ratio:4} {temperature:5}  {:12.1}  {every:6.1} steps", isa.name(), sites.len(), times[0]);
}

/// CPU time of this thread so far [ns], as Linux counts it.
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux counts the time of threads");
    text.split(' ').next().and_then(|t| t.parse().ok()).expect("its first field is a time")
}
