# `make run` and `make test` do all the set-up; see README.md.
SHELL := /bin/bash
.DEFAULT_GOAL := help
.PHONY: help setup run test bench golden picture install install-files uninstall

# Where `make install` puts things. DESTDIR stands before it, for packagers; BIN is a binary that is built already.
PREFIX ?= /usr/local
BIN ?= target/release/relief
BINDIR = $(DESTDIR)$(PREFIX)/bin
MANDIR = $(DESTDIR)$(PREFIX)/share/man/man1
BASHDIR = $(DESTDIR)$(PREFIX)/share/bash-completion/completions
ZSHDIR = $(DESTDIR)$(PREFIX)/share/zsh/site-functions
FISHDIR = $(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d

# Tests and golden images belong to the software driver, whatever card this machine has. Override: RELIEF_ADAPTER=NAME.
test golden picture: export RELIEF_ADAPTER ?= cpu
test: export RUSTDOCFLAGS = -D warnings

help:
	@echo 'make run [FILE=map.png]  fly over the Grand Canyon, or over FILE (without a display: draws relief-view.png)'
	@echo 'make test                formatting, lints, tests, documentation'
	@echo 'make bench               the benchmarks'
	@echo 'make golden              renews the golden images; look at them before you commit'
	@echo "make picture             renews the README's picture"
	@echo 'make setup               installs what running and testing need'
	@echo 'make install             binary, manual pages and shell completions into PREFIX ($(PREFIX)); make uninstall'

setup:
	@.ci/setup.sh test

run:
	@.ci/setup.sh run
	cargo run --release --locked -- $(if $(FILE),"$(FILE)")

test:
	@.ci/setup.sh test
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo test --locked
	cargo doc --locked --no-deps
	@echo 'make test: formatting, lints, tests (with the documentation examples) and documentation are all in order.'

bench:
	@.ci/setup.sh run
	cargo bench --locked

golden:
	@.ci/setup.sh test
	RELIEF_UPDATE_GOLDEN=1 cargo test --locked --test golden

picture:
	@.ci/setup.sh run
	cargo run --release --locked -- render --view start --size 1280x720 -o assets/readme.png

install:
	@.ci/setup.sh run
	cargo build --release --locked
	@$(MAKE) --no-print-directory install-files

# What is built already; the manual and the completions come from the binary itself.
install-files:
	@mkdir -p $(BINDIR) $(MANDIR) $(BASHDIR) $(ZSHDIR) $(FISHDIR)
	@install -m 755 $(BIN) $(BINDIR)/relief
	@$(BIN) man --into $(MANDIR)
	@$(BIN) completions bash > $(BASHDIR)/relief
	@$(BIN) completions zsh > $(ZSHDIR)/_relief
	@$(BIN) completions fish > $(FISHDIR)/relief.fish
	@echo 'installed into $(DESTDIR)$(PREFIX): bin/relief, its manual pages, completions for bash, zsh and fish'

uninstall:
	@rm -f $(BINDIR)/relief $(MANDIR)/relief.1 $(MANDIR)/relief-*.1 $(BASHDIR)/relief $(ZSHDIR)/_relief $(FISHDIR)/relief.fish
	@echo 'removed from $(DESTDIR)$(PREFIX)'
