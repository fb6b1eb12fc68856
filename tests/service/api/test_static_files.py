"""The static files: which modules a script needs, and a version that follows their content."""

import os
from pathlib import Path

import pytest

from service.api.static_files import StaticFolder, UnresolvedImportError


def write(folder: Path, **modules: str) -> Path:
    """Write modules; `pages__run` is `pages/run.js`."""
    for name, text in modules.items():
        path = folder / f"{name.replace('__', '/')}.js"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_modules_are_found_whatever_their_folder_the_nearest_first(tmp_path: Path) -> None:
    write(
        tmp_path,
        pages__run='/** A page. */\nimport { a } from "../charts/line.js";\nimport "./near.js";\n',
        pages__near='export { b } from "../texts/deep/words.js";',
        charts__line='import * as c from "../texts/deep/words.js";\nexport const a = c;\n',
        texts__deep__words="export const b = 1;",
        unused="export const nothing = 0;",
    )
    found = StaticFolder(tmp_path).modules("pages/run.js")
    assert found == ("pages/run.js", "charts/line.js", "pages/near.js", "texts/deep/words.js")


@pytest.mark.parametrize(
    "statement",
    [
        'import "./b.js";',
        "import './b.js';",
        'import b from "./b.js";',
        'import b, { c } from "./b.js";',
        'import * as b from "./b.js";',
        'import { b as c, $d } from "./b.js";',
        'import {\n  b,\n  c,\n} from "./b.js";',
        'import{b}from "./b.js";',
        'export * from "./b.js";',
        'export { b } from "../x/b.js";',
        'export const c = 1;\nimport { b } from "./b.js";',
    ],
)
def test_every_form_of_import_is_followed(tmp_path: Path, statement: str) -> None:
    write(tmp_path, x__a=statement, x__b="")
    assert StaticFolder(tmp_path).modules("x/a.js") == ("x/a.js", "x/b.js")


def test_modules_that_import_each_other_are_named_once(tmp_path: Path) -> None:
    write(tmp_path, a='import "./b.js";', b='import "./a.js";\nimport "./b.js";')
    assert StaticFolder(tmp_path).modules("a.js") == ("a.js", "b.js")


def test_text_that_only_looks_like_an_import_is_none(tmp_path: Path) -> None:
    write(
        tmp_path, a='const said = "from";\nsay(`moved from "./b.js"`);\nexport const c = "./d.js";'
    )
    assert StaticFolder(tmp_path).modules("a.js") == ("a.js",)


def test_imports_that_lead_nowhere_are_refused_all_at_once(tmp_path: Path) -> None:
    write(
        tmp_path,
        pages__run='import "./gone.js";\nimport "../parts/known.js";\nimport "../../outside.js";',
        parts__known='import "uplot";\nimport "/parts/known.js";',
    )
    with pytest.raises(UnresolvedImportError) as refusal:
        StaticFolder(tmp_path)
    for fault in (
        "pages/run.js imports './gone.js'",
        "pages/run.js imports '../../outside.js'",
        "parts/known.js imports 'uplot'",
        "parts/known.js imports '/parts/known.js'",
    ):
        assert fault in str(refusal.value)
    assert "known.js'" not in str(refusal.value).replace("'/parts/known.js'", "")


def test_the_version_changes_with_a_file_s_content_and_name_alone(tmp_path: Path) -> None:
    write(tmp_path, a="1;")
    first = StaticFolder(tmp_path).version
    os.utime(tmp_path / "a.js", (0, 0))
    assert StaticFolder(tmp_path).version == first
    write(tmp_path, a="2;")  # of the same size
    second = StaticFolder(tmp_path).version
    (tmp_path / "a.js").rename(tmp_path / "b.js")
    assert len({first, second, StaticFolder(tmp_path).version}) == 3
