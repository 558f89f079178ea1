"""Hooks of mkdocs.yml: the README, the changelog and the tutorials' notebooks become pages of the site.

Links between Markdown files are as in the repository. Those that lead outside docs/ lead to copies in the site.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = {"index.md": ROOT / "README.md", "changelog.md": ROOT / "CHANGELOG.md"}
LINK = re.compile(r"(?<=\]\()(?!\w+:|#)([^)#\s]+)")


def on_files(files: Files, *, config: Any) -> Files:
    """Adds the pages that are not Markdown files of docs/, and what pages link to outside docs/."""
    texts = {file.src_uri: Path(file.abs_src_path or "") for file in files if file.is_documentation_page()}
    texts |= PAGES | {f"tutorials/{path.stem}.md": path for path in sorted((DOCS / "tutorials").glob("*.ipynb"))}
    for uri, path in texts.items():
        text = _text(path)
        if uri not in files.src_uris:
            files.append(File.generated(config, uri, content=text))
        for target in LINK.findall(text):
            outside = (path.parent / target).resolve()
            if (
                files.get_file_from_path(_uri(outside)) is None
                and outside.exists()
                and not outside.is_relative_to(DOCS)
            ):
                _add(files, outside, config)
    return files


def on_page_markdown(markdown: str, *, page: Any, config: Any, files: Files) -> str:
    """Links as in the repository become links of the site."""
    uri = page.file.src_uri
    source = PAGES.get(uri, DOCS / uri)
    if uri.startswith("sources/"):
        return markdown

    def in_site(link: re.Match[str]) -> str:
        target = (source.parent / link[1]).resolve()
        return os.path.relpath(_uri(target), Path(uri).parent) if target.exists() else link[1]

    return LINK.sub(in_site, markdown)


def _uri(path: Path) -> str:
    """Where a file of the repository is in the site."""
    for uri, page in PAGES.items():
        if path == page:
            return uri
    if path.is_relative_to(DOCS):
        uri = path.relative_to(DOCS).as_posix()
        return uri.removesuffix(".ipynb") + ".md" if uri.endswith(".ipynb") else uri
    uri = f"sources/{path.relative_to(ROOT).as_posix()}"
    return f"{uri}/index.md" if path.is_dir() else uri if path.suffix else f"{uri}.txt"


def _add(files: Files, path: Path, config: Any) -> None:
    """A file as it is; a directory as a page with links to its files."""
    if path.is_file():
        files.append(File.generated(config, _uri(path), abs_src_path=str(path)))
        return
    inside = sorted(file for file in path.rglob("*") if file.is_file() and "__pycache__" not in file.parts)
    lines = [f"# {path.relative_to(ROOT)}", ""]
    for file in inside:
        if files.get_file_from_path(_uri(file)) is None:
            _add(files, file, config)
        name = file.relative_to(path).as_posix()
        lines.append(f"- [{name}]({os.path.relpath(_uri(file), _uri(path / 'x').rpartition('/')[0])})")
    files.append(File.generated(config, _uri(path), content="\n".join(lines) + "\n"))


def _text(path: Path) -> str:
    """Markdown; of a notebook its text and its code."""
    if path.suffix != ".ipynb":
        return path.read_text(encoding="utf-8")
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
    return "\n\n".join(parts) + "\n"
