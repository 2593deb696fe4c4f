"""A run's page is served to this machine, and nothing else is."""

import threading
import urllib.error
import urllib.request

import pytest

from primitives.errors import PalpateError
from recognition.report.served import server


@pytest.fixture
def address(tmp_path):
    (tmp_path / "report.html").write_text("<p>here</p>")
    (tmp_path / "secret.txt").write_text("no")
    with server(tmp_path, 0) as serving:
        threading.Thread(target=serving.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{serving.server_address[1]}"
        serving.shutdown()


def test_the_page_is_there(address):
    assert urllib.request.urlopen(f"{address}/").read() == b"<p>here</p>"


@pytest.mark.parametrize(
    ("path", "host", "code"), [("/secret.txt", None, 404), ("/", "evil.example:80", 403)]
)
def test_nothing_else_is_answered(address, path, host, code):
    request = urllib.request.Request(address + path, headers={"Host": host} if host else {})
    with pytest.raises(urllib.error.HTTPError) as error:
        urllib.request.urlopen(request)
    assert error.value.code == code


def test_a_folder_without_a_page_is_refused(tmp_path):
    with pytest.raises(PalpateError, match=r"no report\.html"):
        server(tmp_path, 0)
