"""Hooks of the documentation site: its pages are the repository's, each at its own path.

A relative link between two files, such as `../results/README.md` from `docs/paper.md`, then leads
to the same page on the site as in the repository.
"""

from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PUBLISHED = (
    "*.md",
    "docs/**/*.md",
    "docs/*.png",
    "docker/README.md",
    "docker/monitoring/*",
    "results/*.*",
)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Publish the files of `PUBLISHED`, and of those below `docs_dir` no other."""
    for file in [file for file in files if file.src_dir == config.docs_dir]:
        files.remove(file)
    for pattern in PUBLISHED:
        for path in sorted(ROOT.glob(pattern)):
            name = path.relative_to(ROOT).as_posix()
            files.append(File(name, str(ROOT), config.site_dir, config.use_directory_urls))
    return files
