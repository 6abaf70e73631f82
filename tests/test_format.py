"""The C++ sources are as .clang-format says."""
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ["benchmarks", "common", "demo", "examples", "filter_amls", "filter_noisy_powercrust", "filter_pn_refine", "tests"]


def test_sources_are_formatted():
    files = sorted(f for folder in FOLDERS for f in (ROOT / folder).rglob("*") if f.suffix in (".h", ".cpp"))
    assert files
    clang_format = Path(sys.executable).parent / "clang-format"
    run = subprocess.run([clang_format, "--dry-run", "--Werror", *files], capture_output=True, text=True)
    assert run.returncode == 0, f"run {clang_format} -i on the files named below\n{run.stderr[:2000]}"
