"""The manifests of `docker/kuberay.yaml`, as far as they can be judged without a cluster."""

from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
import yaml

from service.address import public_of
from service.settings import Settings

FOLDER = Path(__file__).parents[2] / "docker"
MANIFEST = FOLDER / "kuberay.yaml"
README = FOLDER / "README.md"
DOCUMENTS: list[dict[str, Any]] = list(yaml.safe_load_all(MANIFEST.read_text()))
CLUSTER = next(each for each in DOCUMENTS if each["kind"] == "RayCluster")["spec"]
SERVICE = next(each for each in DOCUMENTS if each["kind"] == "Deployment")["spec"]
SERVING: dict[str, dict[str, Any]] = {
    each["name"]: each for each in SERVICE["template"]["spec"]["containers"]
}
TEMPLATES: dict[str, dict[str, Any]] = {
    "head": CLUSTER["headGroupSpec"]["template"],
    "worker": CLUSTER["workerGroupSpecs"][0]["template"],
    "service": SERVICE["template"],
}


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_pod_is_not_root_and_is_watched(name: str) -> None:
    pod = TEMPLATES[name]["spec"]
    assert pod["securityContext"]["runAsNonRoot"] is True
    for container in pod["containers"]:
        assert container["securityContext"]["allowPrivilegeEscalation"] is False
        assert container["securityContext"]["capabilities"] == {"drop": ["ALL"]}
        assert {"readinessProbe", "livenessProbe"} <= container.keys()


def test_every_ray_process_has_the_token_as_a_file() -> None:
    for name in ("head", "worker"):
        [container] = TEMPLATES[name]["spec"]["containers"]
        assert_token_file(container)
    assert_token_file(SERVING["driver"])
    assert_token_file(CLUSTER["autoscalerOptions"])


def test_driver_and_service_share_a_folder_and_no_secret() -> None:
    assert SERVICE["template"]["spec"]["shareProcessNamespace"] is False
    mounts = {
        name: {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
        for name, container in SERVING.items()
    }
    assert mounts["driver"].keys() & mounts["service"].keys() == {"driver", "shared"}
    assert mounts["driver"].keys() == {"driver", "shared", "ray-secret"}
    files = {
        volume["name"]: {item["key"] for item in volume["secret"]["items"]}
        for volume in SERVICE["template"]["spec"]["volumes"]
        if "secret" in volume
    }
    assert files == {"secrets": {"token"}, "ray-secret": {"ray_token"}}
    named = {each["name"] for each in SERVING["service"]["env"]}
    assert not any(name.startswith("RAY_") for name in named)
    assert not any(each["name"].startswith("D3PG_") for each in SERVING["driver"]["env"])
    script, _, folder = SERVING["driver"]["args"]
    assert (script, folder) == ("drive-ray", mounts["driver"]["driver"])
    socket = next(e["value"] for e in SERVING["service"]["env"] if e["name"] == "D3PG_DRIVER")
    assert socket == f"{folder}/pool.sock"


def assert_token_file(container: dict[str, Any]) -> None:
    variables = {each["name"]: each.get("value") for each in container["env"]}
    assert variables["RAY_AUTH_MODE"] == "token"
    folder = str(Path(str(variables["RAY_AUTH_TOKEN_PATH"])).parent)
    assert folder in {mount["mountPath"] for mount in container["volumeMounts"]}


@pytest.mark.parametrize("name", TEMPLATES)
def test_every_volume_mounted_is_there(name: str) -> None:
    pod = TEMPLATES[name]["spec"]
    mounted = {mount["name"] for each in pod["containers"] for mount in each["volumeMounts"]}
    assert mounted == {volume["name"] for volume in pod["volumes"]}
    claims = {each["metadata"]["name"] for each in DOCUMENTS if "Claim" in each["kind"]}
    claimed = [
        volume["persistentVolumeClaim"]
        for volume in pod["volumes"]
        if "persistentVolumeClaim" in volume
    ]
    assert {each["claimName"] for each in claimed} <= claims


def test_the_variables_named_are_settings() -> None:
    named = {each["name"] for each in SERVING["service"]["env"] if each["name"].startswith("D3PG_")}
    assert named <= {f"D3PG_{name.upper()}" for name in Settings.model_fields}


def test_the_service_is_found_where_the_readme_forwards_its_port() -> None:
    env = {each["name"]: each.get("value") for each in SERVING["service"]["env"]}
    address = public_of(str(env["D3PG_PUBLIC_URL"]))
    port = address.origin.rpartition(":")[2]
    assert f"port-forward service/d3pg {port}:80" in README.read_text()
    for probe in ("readinessProbe", "livenessProbe"):
        [header] = SERVING["service"][probe]["httpGet"]["httpHeaders"]
        assert header == {"name": "Host", "value": urlsplit(address.origin).hostname}


def test_nothing_is_reached_from_outside_the_cluster() -> None:
    services = [each["spec"] for each in DOCUMENTS if each["kind"] == "Service"]
    assert [each["type"] for each in services] == ["ClusterIP"]
    assert CLUSTER["headGroupSpec"]["serviceType"] == "ClusterIP"
    policy = next(each for each in DOCUMENTS if each["kind"] == "NetworkPolicy")["spec"]
    selected = policy["podSelector"]["matchLabels"].items()
    assert all(selected <= pod["metadata"]["labels"].items() for pod in TEMPLATES.values())


def test_workers_scale_and_the_service_is_one() -> None:
    workers = CLUSTER["workerGroupSpecs"][0]
    assert CLUSTER["enableInTreeAutoscaling"] is True
    assert 1 <= workers["minReplicas"] <= workers["replicas"] < workers["maxReplicas"]
    assert SERVICE["replicas"] == 1
    assert SERVICE["strategy"] == {"type": "Recreate"}
