#!/usr/bin/env python3
"""Checks which way the imports point: make lint fails on an arrow that goes back.

The house has one direction. A room (a folder or file under crates/halfline/src) imports only
rooms of the levels below its own:

    explain -> scene -> winding -> batch -> nearest -> traverse, builder -> intersect -> rays
          -> tree -> numeric, simd -> mesh -> geometry, storage

Rooms of one level do not know each other: building must not lean on traversal, nor the numeric
rules on an instruction set. Every room may import error and progress. brute_force and textbook,
the judges, import geometry, mesh and numeric (for the scalar triangle test) alone, and no room
imports them: a judge must not share the code that it judges. explain alone imports textbook, for
it is the textbook's walk that it tells. Among the crates: halfline-python -> halfline-cli ->
halfline-study -> halfline-explain, halfline-render, halfline-io, halfline-check -> halfline. Tests
of every crate may use halfline-io for its models, and name it by its path alone: cargo leaves such
a dependency out of what is published.

Modules under #[cfg(test)], and files named tests.rs, may import any room, for that is where engine
and judge meet. lib.rs names every room and is not checked; what it re-exports counts as the room
it comes from.

`unsafe` is allowed in simd/ and storage/ only, tests included.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

LEVELS: list[set[str]] = [
    {"explain"},
    {"scene"},
    {"winding"},
    {"batch"},
    {"nearest"},
    {"traverse", "builder"},
    {"intersect"},
    {"rays"},
    {"tree"},
    {"numeric", "simd"},
    {"mesh"},
    {"geometry", "storage"},
]
EVERYWHERE = {"error", "progress"}
JUDGES = {"brute_force", "textbook"}

# For each room the rooms that it may import, itself aside.
ALLOWED: dict[str, set[str]] = {
    room: set().union(*LEVELS[level + 1 :]) | EVERYWHERE
    for level, rooms in enumerate(LEVELS)
    for room in rooms
}
ALLOWED |= {judge: {"geometry", "mesh", "numeric"} | EVERYWHERE for judge in JUDGES}
ALLOWED["explain"] |= {"textbook"}
ALLOWED |= {"error": set(), "progress": {"error"}}

# For each crate the crates of the workspace that it may depend on.
CRATES: dict[str, set[str]] = {
    "halfline": set(),
    "halfline-io": {"halfline"},
    "halfline-check": {"halfline"},
    "halfline-render": {"halfline"},
    "halfline-explain": {"halfline"},
    "halfline-study": {"halfline", "halfline-io", "halfline-render", "halfline-explain"},
}
CRATES["halfline-cli"] = {*CRATES}
CRATES["halfline-python"] = {*CRATES}

# What the tests of every crate may use, by its path alone.
TESTED_WITH = "halfline-io"

# Where `unsafe` may stand, relative to the library's src.
UNSAFE_FOLDERS = {"simd", "storage"}


@dataclass(frozen=True)
class Token:
    """An identifier or a punctuation mark of Rust, and the line on which it stands."""

    text: str
    line: int


@dataclass(frozen=True)
class Import:
    """A path from the crate's root that a file names: its first segment, and where it stands."""

    name: str
    line: int
    in_test: bool


# Whatever the first alternatives match is no code. A lifetime is told from a character by the
# missing closing quote; block comments nest, and so are finished by hand.
LEXEME = re.compile(
    r"""
    (?P<line_comment>//[^\n]*)
  | (?P<block_comment>/\*)
  | (?P<raw_string>\b(?:b|c)?r(?P<hashes>\#*)".*?"(?P=hashes))
  | (?P<string>"(?:\\.|[^"\\])*")
  | (?P<character>'(?:\\u\{[0-9a-fA-F_]+\}|\\x[0-9a-fA-F]{2}|\\.|[^'\\])')
  | (?P<lifetime>'[A-Za-z_]\w*)
  | (?P<word>(?:r\#)?[A-Za-z_]\w*)
  | (?P<mark>::|[{}\[\]();,*\#$!])
    """,
    re.VERBOSE | re.DOTALL,
)


def tokens_of(source: str) -> list[Token]:
    """The words and the marks of Rust source, without comments, strings and characters."""
    tokens = []
    position = 0
    line = 1
    while match := LEXEME.search(source, position):
        line += source.count("\n", position, match.start())
        end = match.end()
        if match.lastgroup == "block_comment":
            end = end_of_block_comment(source, match.start())
        elif match["word"] or match["mark"]:
            tokens.append(Token(match.group().removeprefix("r#"), line))
        line += source.count("\n", match.start(), end)
        position = end
    return tokens


def end_of_block_comment(source: str, start: int) -> int:
    """Where the comment that opens at `start` ends; nested comments are part of it."""
    depth = 0
    for match in re.compile(r"/\*|\*/").finditer(source, start):
        depth += 1 if match.group() == "/*" else -1
        if depth == 0:
            return match.end()
    return len(source)


def paths_at(texts: list[str], start: int) -> list[list[str]]:
    """The segments of every path that begins at `start`, groups opened up.

    `a::b::c` gives [a, b, c]; `{a::{b, c}, d}` gives [a, b], [a, c], [d].
    """

    def parse(position: int, prefix: list[str]) -> tuple[int, list[list[str]]]:
        segments = list(prefix)
        while position < len(texts):
            text = texts[position]
            if text == "{":
                paths: list[list[str]] = []
                position += 1
                while position < len(texts) and texts[position] != "}":
                    position, found = parse(position, segments)
                    paths += found
                    # Whatever follows a path within a group (as NAME) ends with a comma.
                    while position < len(texts) and texts[position] not in {",", "}"}:
                        position += 1
                    if position < len(texts) and texts[position] == ",":
                        position += 1
                return position + 1, paths
            segments.append(text)
            position += 1
            if position < len(texts) and texts[position] == "::":
                position += 1
            else:
                break
        return position, [segments]

    return parse(start, [])[1]


def imports_of(tokens: list[Token], module: list[str]) -> Iterator[Import]:
    """Every path in a file that starts at the crate's root, written with crate or with super.

    `module` is the path of the file's own module.
    """
    texts = [token.text for token in tokens]
    # The inline modules around the current token: name, depth of braces, whether for tests.
    inline: list[tuple[str, int, bool]] = []
    depth = 0
    for index, token in enumerate(tokens):
        if token.text == "{":
            depth += 1
            if index >= 2 and texts[index - 2] == "mod":
                inline.append((texts[index - 1], depth, is_test_module(texts, index - 2)))
        elif token.text == "}":
            if inline and inline[-1][1] == depth:
                inline.pop()
            depth -= 1
        elif token.text in {"crate", "super"} and texts[index + 1 : index + 2] == ["::"]:
            if index > 0 and texts[index - 1] == "::":
                continue
            position = index + 2
            if token.text == "super":
                here = module + [name for name, _, _ in inline]
                here.pop()
                while here and texts[position : position + 2] == ["super", "::"]:
                    here.pop()
                    position += 2
                if here:
                    continue
            in_test = "tests" in module or any(test for _, _, test in inline)
            for path in paths_at(texts, position):
                yield Import(path[0], token.line, in_test)


def is_test_module(texts: list[str], mod_index: int) -> bool:
    """True if the module whose `mod` stands at `mod_index` has #[cfg(test)] before it."""
    before = "".join(texts[max(0, mod_index - 40) : mod_index])
    return re.search(r"#\[cfg\(test\)\](#\[[^\]]*\])*(pub(\([^)]*\))?)?$", before) is not None


def reexports_of(lib: str) -> dict[str, str]:
    """Which room each name comes from that lib.rs re-exports: `pub use room::{Name, ...}`."""
    texts = [token.text for token in tokens_of(lib)]
    names = {}
    for index in range(len(texts) - 1):
        if texts[index : index + 2] == ["pub", "use"]:
            for path in paths_at(texts, index + 2):
                names[path[-1]] = path[0]
    return names


def module_of(file: Path) -> list[str]:
    """The module path of a file given relative to src: tree/mod.rs is tree, a/b.rs is a::b."""
    parts = list(file.with_suffix("").parts)
    return parts[:-1] if parts[-1] == "mod" else parts


def check_rooms(source_folder: Path) -> Iterator[str]:
    """A line for every import in the library that breaks the order of the rooms."""
    lib = source_folder / "lib.rs"
    reexports = reexports_of(lib.read_text(encoding="utf-8"))
    for path in sorted(source_folder.rglob("*.rs")):
        if path == lib:
            continue
        module = module_of(path.relative_to(source_folder))
        room = module[0]
        if room not in ALLOWED:
            yield f"{path}: unknown room {room}: give it a place in {Path(__file__).name}"
            continue
        tokens = tokens_of(path.read_text(encoding="utf-8"))
        for found in imports_of(tokens, module):
            target = reexports.get(found.name, found.name)
            if found.in_test or target == room:
                continue
            if target == "*":
                yield f"{path}:{found.line}: {room} imports every room: name those it needs"
            elif target not in ALLOWED:
                yield f"{path}:{found.line}: {room} imports {target}, which is no room"
            elif target not in ALLOWED[room]:
                yield f"{path}:{found.line}: {room} may not import {target}"


def check_crates(crates_folder: Path) -> Iterator[str]:
    """A line for every dependency between the workspace's crates that points back."""
    for manifest in sorted(crates_folder.glob("*/Cargo.toml")):
        crate = manifest.parent.name
        if crate not in CRATES:
            yield f"{manifest}: unknown crate {crate}: give it a place in {Path(__file__).name}"
            continue
        in_dependencies = in_dev_dependencies = False
        for number, line in enumerate(manifest.read_text(encoding="utf-8").splitlines(), 1):
            if header := re.match(r"\s*\[(.*)\]", line):
                table = header[1]
                in_dependencies = table.endswith("dependencies")
                in_dev_dependencies = table.endswith("dev-dependencies")
                name = re.search(r"dependencies\.\"?([\w-]+)", table)
            elif in_dependencies:
                name = re.match(r"\s*\"?([\w-]+)", line)
            else:
                name = None
            if in_dev_dependencies and name and name[1] == TESTED_WITH:
                if "workspace" in line or "version" in line:
                    yield f"{manifest}:{number}: tests name {TESTED_WITH} by its path alone"
            elif name and name[1] in CRATES and name[1] not in CRATES[crate]:
                yield f"{manifest}:{number}: {crate} may not depend on {name[1]}"


def check_unsafe(crates_folder: Path) -> Iterator[str]:
    """A line for every `unsafe` outside the places that may have it."""
    library = crates_folder / "halfline" / "src"
    for path in sorted(crates_folder.rglob("*.rs")):
        if path.is_relative_to(library):
            relative = path.relative_to(library)
            if relative.parts[0] in UNSAFE_FOLDERS:
                continue
        for token in tokens_of(path.read_text(encoding="utf-8")):
            if token.text == "unsafe":
                yield f"{path}:{token.line}: unsafe belongs in simd/ and storage/ alone"


def check(root: Path) -> list[str]:
    """All complaints about the workspace at `root`."""
    crates = root / "crates"
    return [
        *check_crates(crates),
        *check_rooms(crates / "halfline" / "src"),
        *check_unsafe(crates),
    ]


def main() -> int:
    """Checks the workspace in which this script lies."""
    complaints = check(Path(__file__).resolve().parent.parent)
    for complaint in complaints:
        print(complaint)
    if not complaints:
        print("import arrows: every arrow points forward")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
