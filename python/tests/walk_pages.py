"""Puts explanations into the page's template, for tests with walks that no mesh at hand makes."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "crates" / "halfline-lecture" / "src" / "explanation" / "page"


def walk_page(title: str, explanation: dict[str, Any]) -> str:
    """The page of an explanation, assembled as `page/mod.rs` does."""
    rust = (PAGE / "mod.rs").read_text(encoding="utf-8")
    scripts = re.findall(r'include_str!\("(\w+\.js)"\)', rust)
    parts = {
        "title": html.escape(title),
        "data": json.dumps(explanation, ensure_ascii=False, allow_nan=False)
        .replace("<", "\\u003c")
        .replace("\u2028", "\\u2028"),
        "style": (PAGE / "walk.css").read_text(encoding="utf-8"),
        "script": "\n".join((PAGE / name).read_text(encoding="utf-8") for name in scripts),
    }
    template = (PAGE / "walk.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], template)
