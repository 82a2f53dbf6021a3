"""The examples for KubeRay, which nobody has applied: what of them can be checked without a cluster.

What Ray Serve reads of them is checked in tests/ray.
"""

import re
from pathlib import Path
from typing import Any

import kubernetes_validate
import pytest
import yaml

from tests.paths import DOCS, ROOT

SERVE, BATCH = ROOT / "deploy" / "kuberay.yaml", ROOT / "deploy" / "kuberay-batch.yaml"


def _objects(file: Path) -> dict[str, Any]:
    return {made["kind"]: made for made in yaml.safe_load_all(file.read_text())}


def _clusters() -> list[Any]:
    return [
        _objects(SERVE)["RayService"]["spec"]["rayClusterConfig"],
        _objects(BATCH)["RayJob"]["spec"]["rayClusterSpec"],
    ]


def _groups() -> list[Any]:
    return [
        group for cluster in _clusters() for group in (cluster["headGroupSpec"], *cluster["workerGroupSpecs"])
    ]


@pytest.mark.parametrize("group", _groups())
def test_kubernetes_knows_every_field_of_a_pod_without_rights(group: dict[str, Any]) -> None:
    assert all(isinstance(value, str) for value in group["rayStartParams"].values())
    template = group["template"]
    pod = {"apiVersion": "v1", "kind": "Pod", "metadata": {"name": "a"} | template["metadata"]}
    pod |= {"spec": template["spec"]}
    kubernetes_validate.validate(pod, kubernetes_validate.latest_version(), strict=True)
    (container,) = template["spec"]["containers"]
    assert template["spec"]["securityContext"]["runAsNonRoot"]
    assert container["securityContext"] == {
        "allowPrivilegeEscalation": False,
        "capabilities": {"drop": ["ALL"]},
    }
    mounted = {mount["name"] for mount in container["volumeMounts"]}
    assert mounted == {volume["name"] for volume in template["spec"]["volumes"]}
    processors = group["rayStartParams"]["num-cpus"]
    assert processors in ("0", container["resources"]["limits"]["cpu"])


def test_kubernetes_knows_every_field_of_the_rest() -> None:
    objects = _objects(SERVE)
    assert list(objects) == ["Namespace", "RayService", "NetworkPolicy"]
    for kind in ("Namespace", "NetworkPolicy"):
        kubernetes_validate.validate(objects[kind], kubernetes_validate.latest_version(), strict=True)


def test_the_rest_has_the_form_of_kuberay() -> None:
    """By the names in KubeRay's reference of ray.io/v1, as far as these use them."""
    service, job = _objects(SERVE)["RayService"], _objects(BATCH)["RayJob"]
    assert service["apiVersion"] == job["apiVersion"] == "ray.io/v1"
    assert set(service["spec"]) == {"serveConfigV2", "rayClusterConfig"}
    assert isinstance(service["spec"]["serveConfigV2"], str)
    assert set(job["spec"]) == {
        *("entrypoint", "backoffLimit", "shutdownAfterJobFinishes", "ttlSecondsAfterFinished"),
        "rayClusterSpec",
    }
    for cluster in _clusters():
        assert set(cluster) - {"enableInTreeAutoscaling"} == {
            *("rayVersion", "headGroupSpec", "workerGroupSpecs"),
        }
        for group in cluster["workerGroupSpecs"]:
            assert group["minReplicas"] <= group["replicas"] <= group["maxReplicas"]
            assert set(group) == {
                *("groupName", "replicas", "minReplicas", "maxReplicas", "rayStartParams", "template"),
            }


def test_all_machines_have_the_same_image_and_ray() -> None:
    assert len({group["template"]["spec"]["containers"][0]["image"] for group in _groups()}) == 1
    (version,) = {cluster["rayVersion"] for cluster in _clusters()}
    assert f"FROM rayproject/ray:{version}-" in SERVE.read_text()


def test_who_reads_of_them_is_told_that_they_are_untried() -> None:
    assert all("# UNTRIED: " in file.read_text() for file in (SERVE, BATCH))
    for page in ("operations.md", "docker.md", "cli.md"):
        told = (DOCS / page).read_text()
        for paragraph in re.split(r"\n\n", told):
            assert "kuberay" not in paragraph.replace("KubeRay", "") or "untried" in paragraph, page
