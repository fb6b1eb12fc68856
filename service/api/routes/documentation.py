"""The API's documentation, served completely: it loads nothing from other sites.

Swagger UI's page starts itself with an inline script, which our content security policy forbids
everywhere; here that one script is allowed by its hash.
"""

import base64
import hashlib
import re
from importlib.resources import files
from pathlib import Path
from typing import Literal

from fastapi import FastAPI
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse

from service.api.access.authority import MAY_READ
from service.api.shell import static

DOCUMENT = "/api/v1/openapi.json"
PATH = "/api/v1/docs"
ASSETS = f"{PATH}/assets"
FOLDER = Path(str(files("fastapi_offline"))) / "static"
Asset = Literal["swagger-ui-bundle.js", "swagger-ui.css", "favicon.png"]
INLINE_SCRIPT = re.compile(rb"<script>(.*?)</script>", re.DOTALL)


def add_documentation(app: FastAPI, prefix: str) -> None:
    """Serve the OpenAPI document, and Swagger UI with the assets that FastAPIOffline brings."""
    assets = f"{prefix}{ASSETS}"
    page = get_swagger_ui_html(
        openapi_url=f"{prefix}{DOCUMENT}",
        title=app.title,
        swagger_js_url=f"{assets}/swagger-ui-bundle.js",
        swagger_css_url=f"{assets}/swagger-ui.css",
        swagger_favicon_url=f"{assets}/favicon.png",
    )
    body = _in_our_dress(bytes(page.body), prefix)
    hashes = " ".join(
        f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"
        for script in INLINE_SCRIPT.findall(body)
    )
    policy = (
        f"default-src 'self'; script-src 'self' {hashes}; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data:; object-src 'none'; base-uri 'none'; frame-ancestors 'none'"
    )

    @app.get(DOCUMENT, include_in_schema=False, dependencies=[MAY_READ])
    def document() -> JSONResponse:
        """Answer the OpenAPI document."""
        return JSONResponse(app.openapi())

    @app.get(PATH, include_in_schema=False, dependencies=[MAY_READ])
    async def documentation() -> HTMLResponse:
        """Answer the page."""
        return HTMLResponse(body, headers={"Content-Security-Policy": policy})

    @app.get(f"{ASSETS}/{{name}}", include_in_schema=False, dependencies=[MAY_READ])
    async def documentation_asset(name: Asset) -> FileResponse:
        """Answer a file that the page is made of."""
        return FileResponse(FOLDER / name)


def _in_our_dress(page: bytes, prefix: str) -> bytes:
    """Give Swagger UI's page the dashboard's themes, and a way back to it."""
    folder = f"{prefix}/static/{static().version}"
    head = (
        f'<link rel="stylesheet" href="{folder}/styles/tokens.css">'
        f'<link rel="stylesheet" href="{folder}/styles/api.css">'
        f'<script src="{folder}/parts/theme.js"></script></head>'
    )
    back = f'<body><p class="back"><a href="{prefix}/">Back to the dashboard</a></p>'
    return page.replace(b"</head>", head.encode(), 1).replace(b"<body>", back.encode(), 1)
