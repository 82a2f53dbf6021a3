"""The Dockerfile, the compose file and the Kubernetes example: well-formed, with no rights to spare."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import kubernetes_validate
import pytest
import yaml

from tests.paths import ROOT

KUBERNETES = ROOT / "deploy" / "kubernetes.yaml"
HADOLINT = shutil.which("hadolint", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")


def _user() -> int:
    found = re.search(r"^USER (\d+):", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    assert found
    return int(found[1])


@pytest.fixture(scope="module")
def objects() -> dict[str, dict[str, Any]]:
    """The objects of the Kubernetes example by their kind."""
    return {made["kind"]: made for made in yaml.safe_load_all(KUBERNETES.read_text())}


@pytest.mark.skipif(HADOLINT is None, reason="needs hadolint; the extra dev brings it on Linux")
def test_the_dockerfile_passes_its_linter() -> None:
    done = subprocess.run([str(HADOLINT), str(ROOT / "Dockerfile")], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_kubernetes_knows_every_field(objects: dict[str, dict[str, Any]]) -> None:
    for made in objects.values():
        kubernetes_validate.validate(made, kubernetes_validate.latest_version(), strict=True)


def test_the_pod_has_no_rights_and_is_probed(objects: dict[str, dict[str, Any]]) -> None:
    template = objects["Deployment"]["spec"]["template"]
    pod, (container,) = template["spec"], template["spec"]["containers"]
    assert pod["securityContext"]["runAsNonRoot"] and pod["securityContext"]["runAsUser"] == _user()
    assert container["securityContext"] == {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    assert container["livenessProbe"]["httpGet"]["path"] == "/livez"
    assert container["readinessProbe"]["httpGet"]["path"] == "/readyz"
    assert {"requests", "limits"} == set(container["resources"])
    assert [mount["mountPath"] for mount in container["volumeMounts"]] == ["/tmp", "/var/lib/primfit"]
    # Kubernetes would set PRIMFIT_PORT to an address of the service of that name.
    assert pod["enableServiceLinks"] is False
    assert pod["terminationGracePeriodSeconds"] > 15


def test_jobs_are_kept_in_a_volume_of_the_images_user(objects: dict[str, dict[str, Any]]) -> None:
    pod = objects["Deployment"]["spec"]["template"]["spec"]
    (container,) = pod["containers"]
    environment = {each["name"]: each for each in container["env"]}
    folder = environment["PRIMFIT_JOBS_PATH"]["value"]
    (name,) = (mount["name"] for mount in container["volumeMounts"] if mount["mountPath"] == folder)
    (claim,) = (volume["persistentVolumeClaim"] for volume in pod["volumes"] if volume["name"] == name)
    assert claim["claimName"] == objects["PersistentVolumeClaim"]["metadata"]["name"]
    assert pod["securityContext"]["fsGroup"] == _user()
    composed = yaml.safe_load((ROOT / "compose.yaml").read_text())
    service = composed["services"]["primfit"]
    assert service["environment"]["PRIMFIT_JOBS_PATH"] == folder
    assert service["volumes"] == [f"jobs:{folder}"] and "jobs" in composed["volumes"]
    owned = f"RUN install --directory --owner {_user()} --group {_user()} --mode 700 {folder}\n"
    assert owned in (ROOT / "Dockerfile").read_text()


def test_the_service_finds_the_pods(objects: dict[str, dict[str, Any]]) -> None:
    template = objects["Deployment"]["spec"]["template"]
    (container,), (port,) = template["spec"]["containers"], objects["Service"]["spec"]["ports"]
    assert objects["Service"]["spec"]["selector"].items() <= template["metadata"]["labels"].items()
    assert port["targetPort"] in [own["name"] for own in container["ports"]]


def test_compose_grants_no_rights() -> None:
    service = yaml.safe_load((ROOT / "compose.yaml").read_text())["services"]["primfit"]
    assert service["read_only"] and service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]
    assert service["tmpfs"][0].startswith("/tmp:")
    assert {"cpus", "mem_limit", "pids_limit", "healthcheck"} <= set(service)
    assert service["stop_grace_period"] == "30s"
    assert all(address.startswith("127.0.0.1:") for address in service["ports"])
