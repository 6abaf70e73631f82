"""The folders of the geometry core use those above them in its README, and none below."""
import re
from pathlib import Path

CORE = Path(__file__).parents[1] / "common" / "recon"
FILTERS = ["filter_amls", "filter_noisy_powercrust", "filter_pn_refine"]


def folders_of(text):
    return ["", *re.findall(r"^\| `(\w+)/` ", text, re.MULTILINE)]


def test_each_folder_uses_those_above_it():
    order = folders_of((CORE / "README.md").read_text())
    assert set(order[1:]) == {f.name for f in CORE.iterdir() if f.is_dir()}, "common/recon/README.md lists other folders"
    upward = []
    for file in sorted(f for f in CORE.rglob("*") if f.suffix in (".h", ".cpp")):
        own = "/".join(file.relative_to(CORE).parts[:-1])
        for folder in re.findall(r"#include <recon/(?:(\w+)/)?\w+\.h>", file.read_text()):
            if order.index(folder) > order.index(own):
                upward.append(f"{file.relative_to(CORE)} includes from {folder}/")
        assert not re.search(rf"#include <(?:{'|'.join(FILTERS)}|meshlab)/", file.read_text()), f"{file} includes from above the core"
    assert not upward
