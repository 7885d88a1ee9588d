//! Random valid scenes: how many end finite with a closed ledger, how many stop with an error, how many are unsound.
//! `cargo run --release -p hvi-impact --example fuzz -- 1000`
#[path = "../tests/common/mod.rs"]
mod common;

fn main() {
    let count: usize = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(1000);
    let mut seed = 88172645463325252u64;
    let scenes: Vec<serde_json::Value> = (0..count).map(|_| common::random_scene(&mut seed)).collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let (stopped, unsound) = (std::sync::Mutex::new(Vec::new()), std::sync::Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                while let Some(scene) = scenes.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    match common::try_run(scene.clone(), &hvi_kit::Ctx::quiet()) {
                        Ok(impact) => {
                            if let Some(why) = common::unsound(&impact) {
                                unsound.lock().expect("no panic").push(format!("{why}: {scene}"));
                            }
                        }
                        Err(why) => stopped.lock().expect("no panic").push(format!("{why}: {scene}")),
                    }
                }
            });
        }
    });
    let (stopped, unsound) = (stopped.into_inner().expect("no panic"), unsound.into_inner().expect("no panic"));
    println!("{count} scenes: {} stopped with an error, {} unsound", stopped.len(), unsound.len());
    stopped.iter().chain(&unsound).for_each(|line| println!("{line}"));
}
