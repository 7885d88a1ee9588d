//! The same bits on every instruction set and for any number of threads.
mod common;
use common::{aluminium, copper};
use hvi_eos::Instructions;
use hvi_impact::Params;
use hvi_impact::kernel::Kernel;
use hvi_impact::material::{Law, Material, Switches};
use hvi_impact::method::{Scheme, Transfer};
use hvi_impact::particle::Particle;
use hvi_impact::scene::{Layout, particles};
use hvi_impact::step::{Setting, State};
use serde_json::json;

/// A small sphere on a small plate after `steps` steps, its setting changed: all particles, by number.
fn run<const D: usize>(space: &str, steps: usize, change: &dyn Fn(&mut Setting<D>)) -> Vec<Particle<D>> {
    let params: Params = serde_json::from_value(json!({
        "projectile": { "shape": "sphere", "diameter": "2 mm", "material": "aluminium" },
        "plate": { "thickness": "1 mm", "width": "6 mm", "material": "copper" },
        "velocity": "5 km/s", "cells": 3, "space": space, "end": "1 us",
    }))
    .expect("parameters");
    let layout = Layout::of(&params);
    let on = Switches { strength: true, damage: true, spall: true };
    let law = |material: &Material| Law::new(material, material.eos.clone(), on);
    let laws = vec![law(&params.projectile.material), law(&params.plate.material)];
    let densities = [1.0 / laws[0].eos.reference_volume(), 1.0 / laws[1].eos.reference_volume()];
    let mut setting = Setting::<D>::new(layout.cell, laws);
    setting.axisymmetric = space == "axisymmetric";
    setting.mirrors = std::array::from_fn(|d| d > 0);
    change(&mut setting);
    let mut state = State::new(particles::<D>(&params, &layout, &densities), &setting);
    for _ in 0..steps {
        state.step(&setting, 1.0).expect("a step");
    }
    let mut all: Vec<_> = state.particles().collect();
    all.sort_by_key(|p| p.id);
    all
}

/// What a method must give on all instruction sets and with one, two and three threads.
fn same_bits<const D: usize>(space: &str, steps: usize, change: &dyn Fn(&mut Setting<D>)) {
    let known = run::<D>(space, steps, change);
    assert!(known.iter().any(|p| p.plastic_strain > 0.0));
    for instructions in Instructions::all() {
        let found = run::<D>(space, steps, &|setting| {
            change(setting);
            setting.instructions = instructions;
        });
        assert!(found == known, "other bits on {}", instructions.name());
    }
    for threads in [2, 3] {
        let found = run::<D>(space, steps, &|setting| {
            change(setting);
            setting.threads = threads;
        });
        assert!(found == known, "other bits with {threads} threads");
    }
}

#[test]
fn in_space() {
    same_bits::<3>("quarter", 30, &|_| {});
    same_bits::<3>("quarter", 12, &|setting| setting.method.kernel = Kernel::Quadratic);
}

#[test]
fn in_the_plane() {
    same_bits::<2>("axisymmetric", 60, &|_| {});
    same_bits::<2>("axisymmetric", 30, &|setting| setting.method.friction = Some(0.2));
    same_bits::<2>("axisymmetric", 30, &|setting| setting.method.transfer = Transfer::Aflip);
    same_bits::<2>("axisymmetric", 30, &|setting| {
        (setting.method.kernel, setting.method.transfer) = (Kernel::Linear, Transfer::Flip);
    });
    same_bits::<2>("axisymmetric", 30, &|setting| {
        (setting.method.transfer, setting.method.scheme) = (Transfer::Xpic { order: 2 }, Scheme::Musl);
    });
}

/// A slab of aluminium on a slab of copper up to cell `end` after `steps` steps, both Mie-Grueneisen: all particles, by number.
fn line(end: i32, steps: usize, change: &dyn Fn(&mut Setting<1>)) -> Vec<Particle<1>> {
    let law = |material: serde_json::Value| -> Law {
        let material: Material = serde_json::from_value(material).expect("a material");
        Law::new(&material, material.eos.clone(), Switches { strength: true, damage: true, spall: true })
    };
    let mut setting = Setting::<1>::new(1e-4, vec![law(aluminium()), law(copper())]);
    change(&mut setting);
    let all = (-150..2 * end).map(|i| {
        let (body, density, v) = if i < 0 { (0, 2703.0, 3000.0) } else { (1, 8930.0, 0.0) };
        Particle::new([(i as f64 + 0.5) * 5e-5], [v], density * 5e-5, 5e-5, (i + 150) as u32, body)
    });
    let mut state = State::new(all.collect(), &setting);
    for _ in 0..steps {
        state.step(&setting, 1.0).expect("a step");
    }
    let mut all: Vec<_> = state.particles().collect();
    all.sort_by_key(|p| p.id);
    all
}

/// On a line, with Mie-Grueneisen too.
#[test]
fn on_a_line() {
    let known = line(150, 200, &|_| {});
    for instructions in Instructions::all() {
        let found = line(150, 200, &|setting| setting.instructions = instructions);
        assert!(found == known, "other bits on {}", instructions.name());
    }
    assert!(line(150, 200, &|setting| setting.threads = 2) == known, "other bits with two threads");
}

/// Far behind the contact a long slab sleeps: it keeps its bits, and all others are as without sleep to a hundred times the quiet
/// velocity, here 1e-9 of the impact speed; the far end of the copper, which the wave does reach, has woken.
#[test]
fn what_no_wave_has_reached_sleeps() {
    let quiet = 3e-6;
    for (steps, end_sleeps) in [(150, true), (1400, false)] {
        let with = line(250, steps, &|setting| setting.quiet = quiet);
        let without = line(250, steps, &|_| {});
        let asleep = with.iter().filter(|p| p.velocity == [0.0]).count();
        assert_eq!(asleep > 150, end_sleeps, "{asleep}");
        assert_eq!(with[649].velocity == [0.0], end_sleeps);
        for (a, b) in with.iter().zip(&without) {
            let apart = (a.velocity[0] - b.velocity[0]).abs();
            assert!(apart <= 100.0 * quiet, "particle {}: {apart} m/s", a.id);
            assert!((a.energy - b.energy).abs() <= 1e-9 * 3000.0 * 3000.0 * 100.0, "particle {}", a.id);
        }
    }
    let known = line(250, 100, &|setting| setting.quiet = quiet);
    let threads = line(250, 100, &|setting| (setting.quiet, setting.threads) = (quiet, 3));
    assert!(known == threads, "other bits with three threads");
}
