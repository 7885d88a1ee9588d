# The two commands of the README, `make run` and `make test`, with all the set-up they need on a fresh Debian 12.
.PHONY: run test check setup-run setup-test

run: setup-run
	cargo build --release --locked
	target/release/hvi-flow run pipelines/copper.toml

test: setup-test check
	cargo test --workspace --locked

check:
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings

setup-run:
	@sh setup.sh run

setup-test:
	@sh setup.sh test
