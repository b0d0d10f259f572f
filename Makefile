# Short names for scripts/; nothing here that they do not do. ARGS go to the command behind a target:
#   make bench ARGS="--preset paper,fast"
.PHONY: bench test check setup drivers figures

bench:
	scripts/bench.sh $(ARGS)
test:
	scripts/test.sh $(ARGS)
check:
	scripts/check.sh
setup:
	scripts/setup.sh
drivers:
	scripts/setup.sh --drivers
figures:
	scripts/figures.sh
