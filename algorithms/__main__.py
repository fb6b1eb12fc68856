"""`python -m algorithms`: train without a service."""

from algorithms.cli.commands import app

if __name__ == "__main__":
    app()
