"""What is said of the methods' files and of the cards of their weights."""

import json
import shutil

from primfit.benchmark.methods import PAPER
from primfit.benchmark.report.six.differences import differences, head_of
from tests.paths import ROOT

TOP1, L2 = {"clouds": 2500, "top1": 0.98765}, {"clouds": 500, "l2_quartiles": [0.1234, 0.2, 0.5]}


def test_every_head_says_what_is_open_and_what_was_chosen():
    for method in PAPER:
        head = head_of(ROOT / "paper" / f"{method}.py")
        assert head[""].startswith(f'{method.upper()}, "') and head[""].endswith(".")
        assert list(head)[1:] == ["The paper", "It leaves open", "Chosen"]
        assert all("  " not in text and len(text) > 60 for text in head.values())


def test_each_method_is_told_with_the_runs_that_made_its_weights():
    lines = list(differences(["m1", "m2"]))
    text = "\n".join(lines)
    assert '- [m1](../paper/m1.py): M1, "Accelerated Hough transform":' in text
    assert "*Left open:* The cells of the votes;" in text and "*Chosen:* Normals as in" in text
    card = json.loads((ROOT / "paper" / "weights" / "m2.json").read_text())
    assert f"| `m2` | 6,000 | – | 20220 | – | `{card['sha256'][:8]}` |" in lines
    assert lines[-3:] == ["```sh", card["recipe"]["command"], "```"]
    assert "m3" not in text


def test_networks_are_told_with_what_they_reach(tmp_path):
    (tmp_path / "paper" / "weights").mkdir(parents=True)
    shutil.copy(ROOT / "paper" / "m3.py", tmp_path / "paper")
    for name, metrics in (("m3-kind", TOP1), ("m3-cone", L2)):
        recipe = {"command": "python -m train", "clouds": 30000, "epochs": 54}
        card = {
            "name": name,
            "recipe": recipe,
            "seed": 7,
            "metrics": {"benchmark": metrics},
            "sha256": "ab" * 32,
        }
        (tmp_path / "paper" / "weights" / f"{name}.json").write_text(json.dumps(card))
    lines = list(differences(["m3", "m4"], tmp_path))
    assert "| `m3-cone` | 30,000 | 54 | 7 | L2 0.12, 0.2, 0.5 | `abababab` |" in lines
    assert "| `m3-kind` | 30,000 | 54 | 7 | 98.8% right | `abababab` |" in lines
    assert lines.count("python -m train") == 1 and not any("m4.py" in line for line in lines)


def test_nothing_is_said_without_the_files(tmp_path):
    assert list(differences(PAPER, tmp_path)) == []
    (tmp_path / "paper").mkdir()
    shutil.copy(ROOT / "paper" / "m1.py", tmp_path / "paper")
    assert not any("weights" in line for line in differences(["m1"], tmp_path))
