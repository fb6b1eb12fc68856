"""The API's documentation, served whole: it asks nothing of other sites.

Swagger UI's page starts itself with an inline script, which our content security policy forbids
everywhere; here that one script is allowed by its hash.
"""

import base64
import hashlib
import re

from fastapi import FastAPI
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse

from service.api.shell import static

ASSETS = "/api/v1/docs/assets"
PATH = "/api/v1/docs"
INLINE_SCRIPT = re.compile(rb"<script>(.*?)</script>", re.DOTALL)


def add_documentation(app: FastAPI) -> None:
    """Serve Swagger UI from the assets that `app` (a FastAPIOffline) has mounted."""
    page = get_swagger_ui_html(
        openapi_url=str(app.openapi_url),
        title=app.title,
        swagger_js_url=f"{ASSETS}/swagger-ui-bundle.js",
        swagger_css_url=f"{ASSETS}/swagger-ui.css",
        swagger_favicon_url=f"{ASSETS}/favicon.png",
    )
    body = _in_our_dress(bytes(page.body))
    hashes = " ".join(
        f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"
        for script in INLINE_SCRIPT.findall(body)
    )
    policy = (
        f"default-src 'self'; script-src 'self' {hashes}; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data:; object-src 'none'; base-uri 'none'; frame-ancestors 'none'"
    )

    @app.get(PATH, include_in_schema=False)
    async def documentation() -> HTMLResponse:
        """Answer the page."""
        return HTMLResponse(body, headers={"Content-Security-Policy": policy})


def _in_our_dress(page: bytes) -> bytes:
    """Give Swagger UI's page the dashboard's themes, and a way back to it."""
    folder = f"/static/{static().version}"
    head = (
        f'<link rel="stylesheet" href="{folder}/styles/tokens.css">'
        f'<link rel="stylesheet" href="{folder}/styles/api.css">'
        f'<script src="{folder}/parts/theme.js"></script></head>'
    )
    back = '<body><p class="back"><a href="/">Back to the dashboard</a></p>'
    return page.replace(b"</head>", head.encode(), 1).replace(b"<body>", back.encode(), 1)
