"""SCXML of other programs: what becomes a chart, and what is refused at its line and column."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core.documents import LoadError
from pirate_sm.views.interchange.scxml_chart_reader import read_chart

NEWT = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- As an editor of statecharts writes it. -->
<sc:scxml xmlns:sc="http://www.w3.org/2005/07/scxml" xmlns:qt="http://www.qt.io/editor"
          version="1.0" name="newt" datamodel="null">
  <qt:editorinfo initialGeometry="1;2"/>
  <sc:parallel id="newt">
    <sc:state id="Grip" qt:colour="red">
      <sc:initial><sc:transition target="Held"/></sc:initial>
      <sc:state id="Loose">
        <sc:transition event="Hold  Grab" target="Held" cond="In('Crawl.Resting')"/>
      </sc:state>
      <sc:state id="Held"/>
    </sc:state>
    <sc:state id="Crawl">
      <sc:state id="Crawl.Resting"/>
      <sc:state id="Ahead"><sc:transition event="Rest" target="Crawl.Resting" type="external"/>
      </sc:state>
    </sc:state>
  </sc:parallel>
</sc:scxml>
"""


def test_ids_become_names_with_their_region() -> None:
    document, outline = read_chart(NEWT, "newt.scxml", "other")

    assert document.data["name"] == "newt"
    assert outline.regions == ("Grip", "Crawl")
    assert outline.states == (("Loose", "Held"), ("Resting", "Ahead"))
    assert outline.initial == ("Held", "Resting")
    assert [(each.source, each.event, each.target, each.guard) for each in outline.transitions] == [
        ("Grip.Loose", "Hold", "Grip.Held", "In('Crawl.Resting')"),
        ("Grip.Loose", "Grab", "Grip.Held", "In('Crawl.Resting')"),
        ("Crawl.Ahead", "Rest", "Crawl.Resting", ""),
    ]


def faults(text: str) -> list[str]:
    with pytest.raises(LoadError) as raised:
        read_chart(text, "x.scxml", "x")
    return [
        f"{each.place.line}:{each.place.column} {each.message}" for each in raised.value.problems
    ]


def chart(inside: str, attributes: str = "") -> str:
    """Return SCXML with two regions; `inside` begins in line 3, column 1."""
    return (
        f'<scxml xmlns="http://www.w3.org/2005/07/scxml" {attributes}><parallel id="top">\n'
        f'<state id="Bow"><state id="one"/></state><state id="Arm"><state id="a"/>\n'
        f"{inside}\n</state></parallel></scxml>"
    )


@pytest.mark.parametrize(
    ("inside", "says"),
    [
        ('<history id="h"/>', "3:1 <history> in <state> is not supported in a chart"),
        ('<final id="f"/>', "3:1 <final> in <state> is not supported in a chart"),
        ("<onentry><log/></onentry>", "3:1 <onentry> in <state> is not supported in a chart"),
        ("<onexit/>", "3:1 <onexit> in <state> is not supported in a chart"),
        ('<invoke type="x"/>', "3:1 <invoke> in <state> is not supported in a chart"),
        ("<datamodel/>", "3:1 <datamodel> in <state> is not supported in a chart"),
        ('<parallel id="p"/>', "3:1 <parallel> in <state> is not supported in a chart"),
        ("<stat/>", "3:1 SCXML has no element <stat>"),
        ("<state/>", "3:1 <state> needs an id"),
        ('<state id="a"/>', "3:1 the id 'a' stands twice; first in line 2"),
        ('<state id="Arm"/>', "3:1 the id 'Arm' stands twice; first in line 2"),
        ('<state id="Arm.a"/>', "3:1 another state is named 'Arm.a' in the chart, too"),
        ('<state id="c" colour="red"/>', "3:15 <state> has no attribute 'colour'"),
        ('<state id="c" initial="d"/>', "3:15 'd' is not a state directly inside <state>"),
        (
            '<state id="c"\n  initial="e"><state id="d"><state id="e"/></state></state>',
            "4:3 'e' is not a state directly inside <state>",
        ),
        ("<initial/>", "3:1 <initial> has one <transition>, which has a target and nothing else"),
        (
            '<transition event="e" target="a"/>',
            "3:1 a transition of the whole region 'Arm' is not supported",
        ),
    ],
)  # fmt: skip
def test_what_a_chart_cannot_have_is_refused(inside: str, says: str) -> None:
    assert faults(chart(inside)) == [says]


@pytest.mark.parametrize(
    ("transition", "says"),
    [
        ('target="a"', "4:1 a transition without an event or without a target is not supported"),
        ('event="E"', "4:1 a transition without an event or without a target is not supported"),
        ('event=" " target="a"', "4:1 a transition without an event or without a target is"),
        ('event="E" target="a c"', "4:23 a transition has one target"),
        ('event="E" target="one"', "4:23 a transition of Arm must stay in Arm"),
        ('event="E" target="b"', "4:23 there is no state 'b'"),
        ('event="*" target="a"', "4:13 an event is named by letters, digits and underscores"),
        ('event="E.f" target="a"', "4:13 an event is named by letters, digits and underscores"),
        ('event="E" target="a" type="internal"', "4:34 a transition of type 'internal' is not"),
        ('event="E" target="a" cond="x > 1"', "4:34 In('…') was expected instead of 'x'"),
        ('event="E" target="a" cond="In(a)"', "4:34 In needs the id of a state in quotes"),
        ('event="E" target="a" cond="In(\'a\'"', "4:34 ')' was expected instead of the end"),
        ('event="E" target="a" cond="In(\'a\') &lt; 1"', "4:34 '<' was not expected here"),
        ('event="E" target="a" cond="In(\'a\') == 1"', "4:34 only true and false can be compared"),
        ('event="E" target="a" cond=""', "4:34 In('…') was expected instead of the end"),
        ('event="E" target="a" cond="In(\'z\')"', "4:34 there is no state 'z'"),
        (f'event="E" target="a" cond="{"(" * 60}"', "4:34 this is nested more than 50 deep"),
    ],
)  # fmt: skip
def test_a_transition_that_a_chart_cannot_have_is_refused(transition: str, says: str) -> None:
    found = faults(chart(f'<state id="c">\n<transition {transition}/></state>'))

    assert len(found) == 1
    assert found[0].startswith(says)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (chart("", 'version="2.0"'), "1:48 version '2.0' of SCXML is not known"),
        (chart("", 'datamodel="xpath"'), "1:48 guards in the datamodel 'xpath' cannot be read"),
        (chart("", 'initial="a"'), "1:48 'a' is not a state directly inside <scxml>"),
        ("<svg/>", '1:1 <svg> is not SCXML: <scxml xmlns="http://www.w3.org/2005/07/scxml"> is'),
        ('<scxml xmlns="urn:x"/>', "1:1 <scxml> is not SCXML"),
        ("<scxml/>", "1:1 a chart has one <parallel> in <scxml>, and in it a <state> for each"),
        ("<scxml><state id='a'/></scxml>", "1:1 a chart has one <parallel> in <scxml>"),
        ("<scxml><parallel id='a'/></scxml>", "1:8 a chart has one <parallel> in <scxml>"),
        ("<scxml><parallel><state id='b'/></parallel></scxml>", "1:18 the region 'b' has no"),
        ("<scxml>", "1:8 this is not XML: no element found"),
        ("", "1:1 this is not XML: no element found"),
        ("<scxml>\n <é a='1' a='2'/></scxml>", "2:11 this is not XML: duplicate attribute"),
        ("<a>" * 40, "1:97 elements are nested more than 32 deep"),
        (f"<a>{'<b/>' * 20_000}</a>", "1:80000 more than 20000 elements"),
    ],
)  # fmt: skip
def test_what_is_no_statechart_is_refused(text: str, says: str) -> None:
    assert any(each.startswith(says) for each in faults(text))


def test_all_faults_are_listed_at_once_and_none_of_them_twice() -> None:
    text = chart(
        '<state id="c"><history id="h"/><onentry><send event="x"/></onentry>\n'
        '<transition event="E" target="h"/><transition event="E" target="z" cond="In(z)"/></state>'
    )

    assert faults(text) == [
        "3:15 <history> in <state> is not supported in a chart",
        "3:32 <onentry> in <state> is not supported in a chart",
        "4:57 there is no state 'z'",
        "4:68 In needs the id of a state in quotes: In('…')",
    ]


@pytest.mark.parametrize(
    "declared",
    [
        "<!DOCTYPE scxml>",
        '<!DOCTYPE scxml [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>',
        '<!DOCTYPE scxml [<!ENTITY a SYSTEM "file:///etc/hostname">]>',
        '<!DOCTYPE scxml [<!ENTITY % a SYSTEM "http://localhost/a.dtd"> %a;]>',
        '<!DOCTYPE scxml SYSTEM "a.dtd">',
    ],
)
def test_entities_are_refused_before_one_is_read(declared: str) -> None:
    text = f'<?xml version="1.0"?>\n  {declared}<scxml name="&a;&b;"/>'

    assert faults(text) == [
        "2:3 a DOCTYPE is not allowed: its entities could expand or name other files"
    ]


def test_an_entity_that_nobody_declares_is_refused() -> None:
    assert faults("<scxml>&a;</scxml>") == ["1:8 this is not XML: undefined entity"]


@pytest.mark.parametrize(
    ("condition", "guard"),
    [
        ("In('one')", "In('Bow.one')"),
        ('In("one")', "In('Bow.one')"),
        ("!In('one')", "not In('Bow.one')"),
        ("!!In('one')", "In('Bow.one')"),
        ("not not not In('one')", "not In('Bow.one')"),
        ("In('one') == false", "not In('Bow.one')"),
        ("In('one') === true", "In('Bow.one')"),
        ("In('one') != true", "not In('Bow.one')"),
        ("In('one') !== false", "In('Bow.one')"),
        ("!In('one') == false", "In('Bow.one')"),
        ("not In('one') == False", "not not In('Bow.one')"),
        ("In('one') && In('a') || In('a')", "In('Bow.one') and In('Arm.a') or In('Arm.a')"),
        ("In('one') and (In('a') or In('a'))", "In('Bow.one') and (In('Arm.a') or In('Arm.a'))"),
        ("!(In('one') || In('a'))", "not (In('Bow.one') or In('Arm.a'))"),
    ],
)
def test_guards_are_read_in_ecmascript_and_in_python(condition: str, guard: str) -> None:
    cond = condition.replace('"', "&quot;").replace("&&", "&amp;&amp;")
    text = chart(f'<state id="c"><transition event="E" target="a" cond="{cond}"/></state>')

    _, outline = read_chart(text, "x.scxml", "x")
    assert [each.guard for each in outline.transitions] == [guard]


@given(st.lists(st.sampled_from([*"<>/=' &;é\n", "state ", "scxml", "id", '"', "&a;", "<!--"])))
def test_any_text_is_read_or_refused(pieces: list[str]) -> None:
    for text in ("".join(pieces), chart("".join(pieces)), NEWT[: len(pieces) * 31]):
        with suppress(LoadError):  # any other exception is a fault of ours
            read_chart(text, "x.scxml", "x")
