"""`python -m service.cli`: the same as `d3pg`."""

from service.cli.app import main

main()
