"""Links to files of the repository lead to pages of the site that show them."""

from __future__ import annotations

from website.repository_files import pages, relinked

MISSION = "[bend](../sequences/mitre_bend.yaml)"


def test_a_link_to_a_file_leads_to_its_page() -> None:
    assert relinked(MISSION, "missions.md") == "[bend](files/sequences/mitre_bend.yaml.md)"
    below = MISSION.replace("../", "../../")
    assert relinked(below, "decisions/0001.md") == ("[bend](../files/sequences/mitre_bend.yaml.md)")


def test_a_linked_file_is_shown_with_its_text() -> None:
    ((name, text),) = pages({"missions.md": MISSION})

    assert name == "files/sequences/mitre_bend.yaml.md"
    assert "`````yaml\n" in text
    assert "mission: mitre_bend\n" in text


def test_a_linked_folder_lists_its_files_which_are_shown_too() -> None:
    found = dict(pages({"missions.md": "[examples](examples)"}))

    assert "(examples/held.yaml.md)" in found["files/docs/examples.md"]
    assert "mission: held" in found["files/docs/examples/held.yaml.md"]


def test_a_link_to_a_folder_of_pages_leads_to_their_index() -> None:
    assert relinked("[d](decisions)", "architecture.md") == "[d](decisions/index.md)"


def test_other_links_stay_as_they_are() -> None:
    text = (
        "[page](pipes.md#networks) [here](#networks) [site](https://mcap.dev) [none](nowhere.yaml) "
        "![picture](pictures/bend.svg)\n\n```text\n[code](../sequences/mitre_bend.yaml)\n```\n"
    )

    assert relinked(text, "missions.md") == text
    assert list(pages({"missions.md": text})) == []
