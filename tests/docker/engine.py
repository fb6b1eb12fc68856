"""podman with images of its own, made from nothing: Debian's packages and what pip is told here.

No image registry is asked. What stands for the base images that `Dockerfile` and `compose.yml` name
is made by debootstrap; pip gets the configuration that it has on this machine, as a secret of the
build, and sees the folders that it names.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
PYTHON = "docker.io/library/python:3.11-slim-bookworm"
POSTGRESQL = "docker.io/library/postgres:17-bookworm"
PACKAGES = "python3,python3-pip,ca-certificates,postgresql"
IMAGE = "localhost/d3pg:latest"
CERTIFICATES = Path("/etc/ssl/certs")
CONTAINERS_CONF = """\
[containers]
default_ulimits = ["nofile=4096:4096", "nproc=16384:16384"]
seccomp_profile = "unconfined"
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
"""
"""What podman needs where there is no systemd, and inside of many a virtual machine."""


def can_run() -> bool:
    """Whether this user may run containers here, and make an image for them."""
    return os.geteuid() == 0 and all(map(shutil.which, ("podman", "runc", "debootstrap")))


class Engine:
    """podman, with configuration and storage in a folder."""

    def __init__(self, folder: Path) -> None:
        """Write the configuration; there is no image yet."""
        self._folder = folder
        (folder / "containers.conf").write_text(CONTAINERS_CONF)
        filesystems = Path("/proc/filesystems").read_text().split()
        driver = "overlay" if "overlay" in filesystems else "vfs"
        storage = {"driver": driver, "graphroot": f"{folder}/storage", "runroot": f"{folder}/run"}
        lines = [f'{name} = "{value}"' for name, value in storage.items()]
        (folder / "storage.conf").write_text("\n".join(["[storage]", *lines]) + "\n")
        self.environment = {
            **os.environ,
            "CONTAINERS_CONF": str(folder / "containers.conf"),
            "CONTAINERS_STORAGE_CONF": str(folder / "storage.conf"),
            "DISABLE_HC_SYSTEMD": "true",
        }

    def run(self, *words: str, content: str = "") -> str:
        """Run podman and return what it prints; fails the test with what it complains of."""
        done = subprocess.run(
            ["podman", *words],
            env=self.environment,
            input=content,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"podman {' '.join(words)}: {done.stdout}{done.stderr}"
        return done.stdout

    def make_images(self) -> None:
        """Make what stands for the base images, and build the project's image on it."""
        root = self._folder / "root"
        subprocess.run(
            ["debootstrap", "--variant=minbase", f"--include={PACKAGES}", "bookworm", str(root)],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        _make_like_the_images(root)
        self._import(root, '["python3"]', PYTHON)
        self._import(root, '["postgres-of-debian"]', POSTGRESQL)
        shutil.rmtree(root)
        self._build()

    @property
    def has_images(self) -> bool:
        """Whether they were made already, by an earlier engine in the same folder."""
        return IMAGE in self.run("images", "--format={{.Repository}}:{{.Tag}}").splitlines()

    def remove_containers(self) -> None:
        """Remove all of them, also those that run, with what they have stored."""
        self.run("pod", "rm", "--all", "--force", "--time=0")  # with those that need each other
        self.run("rm", "--all", "--force", "--time=0")
        self.run("volume", "prune", "--force")
        self.run("network", "prune", "--force")

    def remove_images(self) -> None:
        """Remove everything else."""
        self.run("system", "reset", "--force")

    def _import(self, root: Path, command: str, name: str) -> None:
        with subprocess.Popen(["tar", "-C", root, "-c", "."], stdout=subprocess.PIPE) as archive:
            subprocess.run(
                ["podman", "import", "--quiet", "--change", f"CMD {command}", "-", name],
                env=self.environment,
                stdin=archive.stdout,
                stdout=subprocess.DEVNULL,
                check=True,
            )

    def _build(self) -> None:
        """Build as `docker/README.md` says for an index of one's own; layers would take space."""
        settings = pip_settings()
        configuration = self._folder / "pip.conf"
        lines = [f"{name} = {value}" for name, value in settings.items()]
        configuration.write_text("\n".join(["[global]", *lines]) + "\n")
        mounts = {CERTIFICATES, *folders_named(settings.values())}
        self.run(
            "build",
            "--layers=false",
            "--network=host",
            f"--secret=id=pip,src={configuration}",
            "--build-arg=TORCH_INDEX=",
            *(f"--volume={folder}:{folder}:ro" for folder in sorted(mounts)),
            f"--file={ROOT}/docker/Dockerfile",
            f"--tag={IMAGE}",
            str(ROOT),
        )


@contextmanager
def engine_in(folder: Path) -> Iterator[Engine]:
    """An engine with the images; all of it is gone afterwards.

    Where D3PG_CONTAINERS names a folder, the images stay there for the next time.
    """
    kept = os.environ.get("D3PG_CONTAINERS")
    engine = Engine(Path(kept) if kept else folder)
    try:
        engine.remove_containers()  # of a time before that was cut short
        if not engine.has_images:
            engine.make_images()
        yield engine
    finally:
        engine.remove_containers()
        if not kept:
            engine.remove_images()


def pip_settings() -> Mapping[str, str]:
    """What pip is told on this machine, by its files and by variables, which win."""
    listed = subprocess.run(
        [sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True, check=True
    )
    pairs = [line.split("=", 1) for line in listed.stdout.splitlines()]
    pairs.sort(key=lambda pair: pair[0].startswith(":env:"))
    return {name.rpartition(".")[2]: value.strip("'") for name, value in pairs}


def folders_named(values: Iterable[str]) -> set[Path]:
    """The folders on this machine that settings name; of a file and of an index, where it lies."""
    found = set()
    for value in values:
        for word in value.split():
            path = Path(word.removeprefix("file://"))
            if path.is_absolute() and path.exists():
                is_folder = path.is_dir() and word == str(path)
                found.add(path if is_folder else path.parent)
    return found


def _make_like_the_images(root: Path) -> None:
    """Have `python` and pip there as in Python's image, and a start as in PostgreSQL's."""
    (root / "usr/bin/python").symlink_to("python3")
    for marker in root.glob("usr/lib/python3*/EXTERNALLY-MANAGED"):
        marker.unlink()
    shutil.copy(Path(__file__).with_name("postgres-of-debian"), root / "usr/local/bin")
    data = root / "var/lib/postgresql/data"
    data.mkdir(mode=0o700)
    owner = data.parent.stat()
    os.chown(data, owner.st_uid, owner.st_gid)
    for archive in root.glob("var/cache/apt/archives/*.deb"):
        archive.unlink()
