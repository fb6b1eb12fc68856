"""`python -m algorithms`: train without a service."""

from algorithms.commands import app

if __name__ == "__main__":
    app()
