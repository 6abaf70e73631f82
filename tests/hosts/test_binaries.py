"""What is shipped: the plugin files themselves."""
import subprocess

import pytest

from hosts import BUILD

FILES = sorted((BUILD / "plugins").glob("*/*.so"))
HOSTS = ["meshlab-2020.09", "meshlab-2025.07", "pymeshlab-2025.7"]


@pytest.mark.parametrize("host", HOSTS)
def test_every_host_has_the_plugin(host):
    assert (BUILD / "plugins" / host / "libfilter_noisy_powercrust.so").exists()


@pytest.mark.parametrize("file", FILES, ids=lambda f: f"{f.parent.name}/{f.name}")
def test_no_path_of_the_build_is_left(file):
    dynamic = subprocess.run(["readelf", "-d", file], check=True, capture_output=True, text=True).stdout
    assert "RPATH" not in dynamic and "RUNPATH" not in dynamic
    assert "libmeshlab-common.so" in dynamic


@pytest.mark.parametrize("file", FILES, ids=lambda f: f"{f.parent.name}/{f.name}")
def test_only_the_plugins_entry_points_are_visible(file):
    symbols = subprocess.run(["nm", "-D", "--defined-only", file], check=True, capture_output=True, text=True).stdout
    assert {line.split()[-1] for line in symbols.splitlines()} <= {
        "qt_plugin_instance", "qt_plugin_query_metadata", "qt_plugin_query_metadata_v2"}
