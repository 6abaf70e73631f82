"""What is shipped: the plugin files themselves."""
import re
import subprocess

import pytest

from hosts import BUILD, filters_of

FILES = sorted((BUILD / "plugins").glob("*/*.so"))
HOSTS = ["meshlab-2020.09", "meshlab-2025.07", "pymeshlab-2025.7"]
PLUGINS = ["libfilter_amls.so", "libfilter_noisy_powercrust.so", "libfilter_pn_refine.so"]


@pytest.mark.parametrize("host", HOSTS)
def test_every_host_has_the_plugins(host):
    assert [f.name for f in FILES if f.parent.name == host] == PLUGINS


@pytest.mark.parametrize("plugin", PLUGINS)
def test_names_follow_the_hosts_rules(plugin):
    filters = filters_of(BUILD / "plugins" / "meshlab-2025.07" / plugin)
    assert filters
    for f in filters:
        assert f.name and f.name == f.name.strip()
        assert re.fullmatch(r"(generate|compute|apply|meshing)_[a-z0-9_]+", f.python_name), f.python_name


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
