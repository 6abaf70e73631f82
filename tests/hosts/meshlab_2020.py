"""MeshLab 2020.09 of Debian, with our plugins, without touching its installation.

MeshLab 2020 of Debian looks for its library and plugins relative to its program. So a private folder gets copies of the two
programs, and links to MeshLab's library, to its own plugins and to ours.
"""
import os
import re
import select
import shutil
import subprocess
from pathlib import Path
from xml.sax.saxutils import quoteattr


class Display:
    """An X server without a screen (Xvfb). GL is done in software."""

    def __init__(self):
        reader, writer = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
            pass_fds=[writer], stderr=subprocess.DEVNULL)
        os.close(writer)
        number = b""
        while not number.endswith(b"\n") and select.select([reader], [], [], 60)[0]:
            part = os.read(reader, 16)
            if not part:
                break
            number += part
        os.close(reader)
        number = number.decode().strip()
        if not number:
            self.process.kill()
            raise RuntimeError("Xvfb does not start")
        self.name = f":{number}"

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=30)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def is_installed():
    """Later versions, as Debian 13 has one, have no meshlabserver."""
    return Path("/usr/bin/meshlabserver").exists()


def installed():
    """The folder of Debian's libmeshlab-common.so and its plugins."""
    return next(Path("/usr/lib").glob("*/meshlab/libmeshlab-common.so")).parent


def private_install(folder, plugins, more=()):
    """Makes `folder`/bin with meshlab and meshlabserver and all plugins: ours (files of the folder `plugins`) and `more`."""
    system = installed()
    folder = Path(folder)
    programs = folder / "bin"
    libraries = folder / "lib" / system.parent.name / "meshlab"
    for old in (programs, libraries):
        if old.exists():
            shutil.rmtree(old)
    programs.mkdir(parents=True)
    (libraries / "plugins").mkdir(parents=True)
    for program in ("meshlab", "meshlabserver"):
        shutil.copy2(Path("/usr/bin") / program, programs / program)
    (libraries / "libmeshlab-common.so").symlink_to(system / "libmeshlab-common.so")
    for plugin in [*(system / "plugins").glob("*.so"), *Path(plugins).glob("*.so"), *map(Path, more)]:
        link = libraries / "plugins" / plugin.name
        link.unlink(missing_ok=True)  # ours instead of one that is installed
        link.symlink_to(plugin.resolve())
    return programs


def environment(display, home):
    """MeshLab reads settings from the home folder: a private one keeps runs alike and the user's as they are."""
    Path(home).mkdir(parents=True, exist_ok=True)
    return {**os.environ, "DISPLAY": display.name, "HOME": str(home), "LIBGL_ALWAYS_SOFTWARE": "1", "QT_X11_NO_MITSHM": "1"}


def script(*filters):
    """Text of an .mlx script. A filter is (name, [(parameter, type, value, {other attributes})])."""
    lines = ["<!DOCTYPE FilterScript>", "<FilterScript>"]
    for name, parameters in filters:
        lines.append(f" <filter name={quoteattr(name)}>")
        for parameter, kind, value, attributes in parameters:
            more = "".join(f" {key}={quoteattr(str(text))}" for key, text in attributes.items())
            lines.append(f'  <Param type="{kind}" name={quoteattr(parameter)} value={quoteattr(str(value))}{more}/>')
        lines.append(" </filter>")
    lines.append("</FilterScript>")
    return "\n".join(lines) + "\n"


def run_server(programs, display, arguments, folder, timeout=600):
    """Runs meshlabserver in `folder`. \returns the exit code (negative: killed by that signal) and what it printed."""
    process = subprocess.run([str(Path(programs) / "meshlabserver"), *map(str, arguments)], cwd=folder,
                             env=environment(display, Path(programs).parent / "home"), stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout, errors="replace", text=True)
    return process.returncode, process.stdout


def values_in_log(text):
    """The result values that a filter logged: 'components: 1'."""
    values = {}
    for name, value in re.findall(r"^(?:LOG: \d+ )?([a-z_0-9]+): ([-+0-9.e]+|yes|no|nan|inf)$", text, re.M):
        values[name] = {"yes": True, "no": False}.get(value) if value in ("yes", "no") else float(value)
    return values
