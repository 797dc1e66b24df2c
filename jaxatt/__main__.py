"""`python -m jaxatt` is the `jaxatt` command."""

from jaxatt.cli import main

main()
