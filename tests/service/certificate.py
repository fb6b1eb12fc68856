"""A certificate of one's own, for a service or a proxy of a test."""

import subprocess
from pathlib import Path

CALL = "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=here"
FILES = "-keyout key.pem -out chain.pem"


def self_signed(folder: Path, name: str) -> tuple[Path, Path]:
    """Make the files of a name, such as `DNS:lab.localhost`; return certificate and key."""
    call = [*CALL.split(), "-addext", f"subjectAltName={name}", *FILES.split()]
    subprocess.run(call, cwd=folder, check=True, capture_output=True)
    return folder / "chain.pem", folder / "key.pem"
