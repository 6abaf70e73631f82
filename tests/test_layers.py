"""The folders of the geometry core, and of a filter, use those above them in their README, and none below."""
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILTERS = ["filter_amls", "filter_noisy_powercrust", "filter_pn_refine"]
INCLUDE = re.compile(r'^#include ["<]((?:\w+/)*\w+\.h)[">]', re.MULTILINE)


def find_folders(root):
    listed = re.findall(r"^\| `(\w+)/` ", (root / "README.md").read_text(), re.MULTILINE)
    assert set(listed) == {f.name for f in root.iterdir() if f.is_dir()}, f"{root.name}/README.md lists other folders"
    return listed


def list_sources(root):
    return sorted(f for f in root.rglob("*") if f.suffix in (".h", ".cpp"))


@pytest.mark.parametrize("root, first", [("common/recon", [""]), *((root, []) for root in FILTERS)])
def test_each_folder_uses_those_above_it(root, first):
    """Files beside the folders are below all of them in a filter, its plugin; above in the core."""
    order = first + find_folders(ROOT / root)
    prefix = Path(root).name + "/"
    upward = []
    for file in list_sources(ROOT / root):
        own = "/".join(file.relative_to(ROOT / root).parts[:-1])
        for header in INCLUDE.findall(file.read_text()):
            folder = header.removeprefix(prefix).rpartition("/")[0] if header.startswith(prefix) else own
            if own in order and (folder not in order or order.index(folder) > order.index(own)):
                upward.append(f"{file.relative_to(ROOT)} includes {header}")
    assert not upward


def test_the_core_uses_no_filter():
    for file in list_sources(ROOT / "common" / "recon"):
        above = [h for h in INCLUDE.findall(file.read_text()) if h.split("/")[0] in [*FILTERS, "meshlab"]]
        assert not above, f"{file} includes {above}"
