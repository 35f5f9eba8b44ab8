# On a fresh Debian machine with the Rust toolchain, gcc, make and git, these do everything:
#
#   make serve    build, and serve on http://127.0.0.1:8080
#   make test     all that is checked before a change goes in
#   make fuzz     thousands of generated requests to a server, held against its OpenAPI document (about ten minutes)
#   make fuzz-inputs   mutated documents and logs, until Ctrl-C; INPUTS="--inputs 20000 --seed 1" for a number of them
#
# Missing Debian packages are installed, with sudo where needed.

LISTEN ?= 127.0.0.1:8080

.PHONY: serve test fuzz fuzz-inputs build openapi

serve: build
	cargo run --release --locked --bin dynident -- serve --listen $(LISTEN)

build:
	@scripts/setup build
	cargo build --release --locked --bin dynident

# One profile throughout: everything is compiled once. The tests come last and end the output.
test:
	@scripts/setup test
	cargo fmt --check
	rustfmt --check --edition 2024 src/effects/*.rs
	target/tools/bin/cargo-deny --locked check licenses sources bans
	cargo clippy --release --locked --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --no-deps
	cargo check --release --locked -p dynident-core
	cargo check --release --locked --lib --no-default-features
	cargo test --release --locked --lib --bins --tests
	cargo test --release --locked --doc

fuzz:
	@scripts/setup test
	scripts/schemathesis

fuzz-inputs:
	@scripts/setup build
	cargo test --release --locked --test fuzz -- campaign $(INPUTS)

openapi:
	cargo run --release --locked -- openapi > openapi/openapi.json.new
	mv openapi/openapi.json.new openapi/openapi.json
