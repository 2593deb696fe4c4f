import json

from recognition import doctor


def test_a_second_owner_of_a_package_name_is_found(monkeypatch):
    owners = {"models": ["palpate", "some-models"], "primitives": ["palpate"]}
    monkeypatch.setattr(doctor, "packages_distributions", lambda: owners)
    findings = doctor.examine()
    wrong = {row.subject: row.text for row in findings.rows if row.state == "wrong"}
    assert not findings.healthy
    assert list(wrong) == ["models"]
    assert "some-models" in wrong["models"]


def test_a_package_that_shadows_ours_is_found(monkeypatch, tmp_path):
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "__init__.py").touch()
    monkeypatch.setattr(doctor, "packages_distributions", dict)
    monkeypatch.delitem(__import__("sys").modules, "models", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    wrong = [row for row in doctor.examine().rows if row.state == "wrong"]
    assert [row.subject for row in wrong] == ["models"]
    assert str(tmp_path) in wrong[0].text


def test_a_missing_dependency_names_its_cure(monkeypatch):
    monkeypatch.setattr(doctor, "requires", lambda _: ["numpy>=2.0", "no-such-thing>=1", "x; extra == 'dev'"])
    wrong = [row for row in doctor.examine().rows if row.state == "wrong"]
    assert [row.text for row in wrong] == ["missing; pip install 'no-such-thing>=1'"]


def test_findings_read_as_text_and_as_json():
    findings = doctor.examine()
    assert findings.healthy
    assert "embreex" in findings.as_text()
    assert json.loads(json.dumps(findings.as_json()))["healthy"] is True
