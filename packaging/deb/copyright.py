"""The package's file of copyrights: what is given, and a paragraph from the metadata of each bundled package.

Usage: copyright.py HEAD, with the Python that has the packages.
"""

import re
import sys
from importlib.metadata import Distribution, distributions
from pathlib import Path


def licence(package: Distribution) -> str:
    """The name, as the package says it."""
    data = package.metadata
    classifiers = [each for each in data.get_all("Classifier") or () if each.startswith("License ::")]
    named = data.get("License-Expression") or (classifiers[0].rpartition(":: ")[2] if classifiers else None)
    return " ".join((named or data.get("License") or "see its dist-info").split())[:80]


def holders(package: Distribution) -> list[str]:
    """The lines of its licences that say whose it is."""
    texts = [file for file in package.files or () if re.search(r"LICEN|COPYING|NOTICE", file.name, re.I)]
    found = [
        line.strip(" *#\t")
        for text in texts
        for line in Path(str(text.locate())).read_text(errors="replace").splitlines()
        if re.match(r"\W*Copyright\b.*\d{4}", line)
    ]
    return list(dict.fromkeys(found))[:8]


def main(head: str) -> None:
    sys.stdout.write(Path(head).read_text())
    for package in sorted(distributions(), key=lambda each: each.name.lower()):
        if package.name != "hil-motion":
            folder = Path(str(package.locate_file(""))).name
            names = sorted({Path(file).parts[0] for file in package.files or () if ".." not in file.parts})
            files = "\n ".join(f"usr/lib/hil/lib/*/{folder}/{name}*" for name in names)
            owners = "\n ".join(holders(package) or [f"the authors of {package.name}"])
            name = re.sub(r"[^A-Za-z0-9.+-]+", "-", licence(package)) + f"~{package.name}"
            text = f"{licence(package)}\n .\n {package.name} {package.version}; the text is in its dist-info."
            print(f"\nFiles: {files}\nCopyright: {owners}\nLicense: {name}\n {text}")


if __name__ == "__main__":
    main(sys.argv[1])
