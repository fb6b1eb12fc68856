"""Print the service's OpenAPI document, of which `make check` makes types for the modules."""

import json
import sys
import tempfile
from pathlib import Path

from service.api.app import create_app
from service.settings import Settings
from service.store.store import Store
from tests.web.live_service import ReadyDispatcher


def main() -> None:
    """Print the document of a service on an empty database."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data_dir=Path(folder))
        store = Store.open(settings.store_url)
        try:
            json.dump(create_app(settings, store, ReadyDispatcher()).openapi(), sys.stdout)
        finally:
            store.close()


if __name__ == "__main__":
    main()
