import pytest

import hosts
import meshlab_2020
from released_filters import NOISY_POWER_CRUST


@pytest.fixture(scope="session")
def display():
    with meshlab_2020.Display() as screen:
        yield screen


@pytest.fixture(scope="session")
def make_host(display):
    """A host by name, made once."""
    made = {}

    def make(name, plugin):
        if name == "meshlabserver" and not meshlab_2020.is_installed():
            pytest.skip("MeshLab 2020.09 is not installed")
        if (name, plugin) not in made:
            kind = {"pymeshlab": hosts.PyMeshLab, "meshlab-2025.07": hosts.MeshLab2025,
                    "meshlabserver": hosts.MeshLabServer2020}[name]
            made[name, plugin] = kind(plugin, display) if kind is hosts.MeshLabServer2020 else kind(plugin)
        return made[name, plugin]

    return make


HOSTS = ["pymeshlab", "meshlab-2025.07", "meshlabserver"]


@pytest.fixture(params=HOSTS)
def any_host(request, make_host):
    return make_host(request.param, NOISY_POWER_CRUST.plugin)
