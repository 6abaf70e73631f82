"""Adds up test reports: prints 'N passed, N failed' and exits with 1 unless all tests of all expected reports passed."""
import sys
import xml.etree.ElementTree as xml

expected, files = int(sys.argv[1]), [f for f in sys.argv[2:] if not f.endswith("*.xml")]
passed = 0
failed = expected - len(files)  # a test program that died leaves no report
for file in files:
    cases = list(xml.parse(file).getroot().iter("testcase"))
    bad = [c for c in cases if c.find("failure") is not None or c.find("error") is not None or c.get("status") == "fail"]
    skipped = [c for c in cases if c not in bad and (c.find("skipped") is not None or c.get("status") in ("notrun", "disabled"))]
    for case in bad:
        print("failed:", case.get("classname", ""), case.get("name"))
    for case in skipped:
        print("not run:", case.get("classname", ""), case.get("name"))
    passed += len(cases) - len(bad) - len(skipped)
    failed += len(bad)
    if not cases:
        failed += 1
print(f"{passed} passed, {failed} failed")
sys.exit(1 if failed else 0)
