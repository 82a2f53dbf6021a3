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
    written = [mount["mountPath"] for mount in container["volumeMounts"] if not mount.get("readOnly")]
    assert written == ["/tmp", "/var/lib/primfit"]
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


def test_all_lie_in_the_namespace_whose_pods_may_do_little(objects: dict[str, dict[str, Any]]) -> None:
    space = objects["Namespace"]["metadata"]
    assert space["labels"]["pod-security.kubernetes.io/enforce"] == "restricted"
    others = [made["metadata"] for kind, made in objects.items() if kind != "Namespace"]
    assert others and all(one["namespace"] == space["name"] for one in others)
    assert next(iter(objects)) == "Namespace", "what lies in it is made after it"


def test_keys_come_from_a_secret_that_is_in_no_file(objects: dict[str, dict[str, Any]]) -> None:
    pod = objects["Deployment"]["spec"]["template"]["spec"]
    (container,) = pod["containers"]
    settings = {one["name"]: one.get("value") for one in container["env"]}
    (mount,) = [one for one in container["volumeMounts"] if one["name"] == "keys"]
    (volume,) = [one for one in pod["volumes"] if one["name"] == "keys"]
    made = f"create secret generic {volume['secret']['secretName']} --from-file "
    name = KUBERNETES.read_text().partition(made)[2].partition("=")[0]
    assert settings["PRIMFIT_API_KEYS_FILE"] == f"{mount['mountPath']}/{name}" and mount["readOnly"]
    # The files are root's: their group reads them, and no other user.
    assert volume["secret"]["defaultMode"] == 0o440 and pod["securityContext"]["fsGroup"] == _user()
    assert "Secret" not in objects and "PRIMFIT_API_KEYS" not in settings


def test_few_come_in_and_nothing_goes_out(objects: dict[str, dict[str, Any]]) -> None:
    template = objects["Deployment"]["spec"]["template"]
    policy = objects["NetworkPolicy"]["spec"]
    assert policy["podSelector"]["matchLabels"].items() <= template["metadata"]["labels"].items()
    assert policy["policyTypes"] == ["Ingress", "Egress"]
    assert [port["port"] for out in policy["egress"] for port in out["ports"]] == [5432, 53, 53]
    (rule,) = policy["ingress"]
    (own,) = template["spec"]["containers"][0]["ports"]
    assert rule["ports"] == [{"protocol": "TCP", "port": own["name"]}]
    # An empty list would let everybody in.
    assert len(rule["from"]) == 3


def test_a_pod_stays_when_nodes_are_emptied(objects: dict[str, dict[str, Any]]) -> None:
    deployment, budget = objects["Deployment"]["spec"], objects["PodDisruptionBudget"]["spec"]
    assert budget["maxUnavailable"] < deployment["replicas"]
    assert budget["selector"] == deployment["selector"]


def _compose(path: Path) -> Any:
    return yaml.safe_load(path.read_text())


def test_compose_takes_keys_from_a_file_that_is_in_no_image() -> None:
    made = _compose(ROOT / "deploy" / "compose.keys.yaml")
    service, (name,) = made["services"]["primfit"], made["secrets"]
    assert service["secrets"] == [name]
    assert service["environment"] == {"PRIMFIT_API_KEYS_FILE": f"/run/secrets/{name}"}
    assert made["secrets"][name] == {"file": "./primfit.keys"}
    assert "/primfit.keys" in (ROOT / ".gitignore").read_text().splitlines()


def test_compose_grants_no_rights() -> None:
    service = _compose(ROOT / "compose.yaml")["services"]["primfit"]
    assert service["read_only"] and service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]
    assert service["tmpfs"][0].startswith("/tmp:")
    assert {"cpus", "mem_limit", "pids_limit", "healthcheck"} <= set(service)
    assert service["stop_grace_period"] == "30s"
    assert all(address.startswith("127.0.0.1:") for address in service["ports"])
