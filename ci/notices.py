#!/usr/bin/env python3
"""Prints what is linked into the program from elsewhere: names, versions, licences, and the text of each licence once.

    ci/notices.py > THIRD-PARTY.md                # of a statically linked program
    ci/notices.py --dynamic > THIRD-PARTY.md      # of one that finds its C library in the system

Texts come from the sources that Cargo built from. Of the C library and Rust's own, which a static program holds too, they
come from Debian and from the toolchain.
"""
import json
import pathlib
import subprocess
import sys

TARGET = "x86_64-unknown-linux-gnu"
NAMES = ("LICENSE*", "LICENCE*", "COPYING*", "NOTICE*", "UNLICENSE*")
C_LIBRARY = ("/usr/share/doc/libc6-dev/copyright", "/usr/share/common-licenses/LGPL-2.1")


def told(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True).stdout.strip()


def linked():
    """Packages of the registry that the program holds: proc macros and build scripts only run while it is built."""
    metadata = json.loads(told("cargo", "metadata", "--locked", "--format-version", "1"))
    # Cargo's metadata name packages that no feature asks for; its tree does not.
    tree = told("cargo", "tree", "--locked", "--target", TARGET, "--edges", "normal,no-proc-macro", "--prefix", "none")
    held = {tuple(line.split()[:2]) for line in tree.splitlines()}
    packages = [of for of in metadata["packages"] if of["source"] and (of["name"], "v" + of["version"]) in held]
    return sorted(packages, key=lambda of: (of["name"], of["version"]))


def texts_of(package):
    folder = pathlib.Path(package["manifest_path"]).parent
    files = sorted({path for name in NAMES for path in folder.glob(name) if path.is_file()})
    return [path.read_text(encoding="utf-8", errors="replace").strip() for path in files]


def of_the_c_library():
    version = lambda of: told("dpkg-query", "--showformat=${Version}", "--show", of)
    return [
        "- the GNU C Library, Debian's %s: LGPL-2.1-or-later, https://sources.debian.org/src/glibc/; `ci/release` of crossgrain's "
        "source links the program anew, with a C library of your own too" % version("libc6-dev"),
        "- libgcc, Debian's %s: GPL-3.0-or-later with the GCC Runtime Library Exception" % version("libgcc-12-dev"),
    ]


def main():
    rows, texts = [], {}
    for package in linked():
        named = "%s %s" % (package["name"], package["version"])
        rows.append("- %s: %s, %s" % (named, package["license"], package["repository"] or "crates.io"))
        found = texts_of(package)
        if not found:
            sys.exit("the source of %s has no text of its licence; give one in ci/notices.py" % named)
        for text in found:
            texts.setdefault(text, []).append(named)
    sysroot = pathlib.Path(told("rustc", "--print", "sysroot"))
    rust = told("rustc", "--version")
    rows.append("- Rust's standard library, %s: MIT OR Apache-2.0, https://github.com/rust-lang/rust" % rust)
    places = [sysroot / "share/doc/rust/licenses" / ("%s.txt" % of) for of in ("MIT", "Apache-2.0")]
    if "--dynamic" not in sys.argv:
        rows += of_the_c_library()
        places += map(pathlib.Path, C_LIBRARY)
    for place in places:
        whose = "the GNU C Library" if str(place) in C_LIBRARY else "Rust's standard library"
        texts.setdefault(place.read_text(encoding="utf-8").strip(), []).append(whose)
    print("# What crossgrain links from elsewhere\n\ncrossgrain itself is under the MIT licence, in LICENSE.\n")
    print("\n".join(rows))
    for text, whose in sorted(texts.items(), key=lambda of: of[1]):
        print("\n## %s\n\n```text\n%s\n```" % (", ".join(whose), text))


if __name__ == "__main__":
    try:
        main()
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit("the notices cannot be made: %s" % error)
