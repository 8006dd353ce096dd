"""What does not come from the studio's own page is refused, in one line that tells of no place on this machine."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import click
import httpx
import pytest
import roles
from corpus import CASES, OK, REFUSED
from studio.served import QUICK, Served, children, pixels, png, studio

from intarsia.foundation.params import OVER
from intarsia.studio import requests, uploads


def refused(answer: httpx.Response, *statuses: int) -> str:
    """The one line of a refusal."""
    assert answer.status_code in (statuses or (400, 401, 403, 404, 405, 413)), (answer.status_code, answer.text[:300])
    line = answer.json()["error"] if answer.headers["content-type"] == "application/json" else answer.text.strip()
    assert isinstance(line, str)
    assert line
    assert "\n" not in line
    assert "Traceback" not in line
    assert "/tmp" not in line
    assert ".py" not in line
    assert str(Path(__file__).parents[2]) not in line
    return line


def asked(served: Served, method: str = "GET", path: str = "/api/jobs", **headers: str) -> httpx.Response:
    known = {name: value.encode() for name, value in headers.items()}
    return httpx.request(method, served.address.rstrip("/") + path, headers=known)


def entered(served: Served) -> str:
    """The cookie of a browser that came in."""
    return httpx.get(served.entrance()).headers["set-cookie"].partition(";")[0]


class TestWhoComesIn:
    def test_the_address_that_is_printed_opens_the_page(self, served: Served) -> None:
        with httpx.Client(base_url=served.address, headers={"Sec-Fetch-Site": "none"}) as browser:
            assert browser.get("/").status_code == 401
            first = browser.get(served.entrance())
            assert first.status_code == 200
            assert 'http-equiv="refresh" content="0;url=/"' in first.text
            cookie = first.headers["set-cookie"].lower()
            assert "httponly" in cookie
            assert "samesite=strict" in cookie
            page = browser.get("/")
            assert page.status_code == 200
            assert page.headers["content-type"].startswith("text/html")
            assert browser.get("/api/jobs").status_code == 200
            policy = page.headers["content-security-policy"]
            assert policy.startswith("default-src 'self';")
            assert "unsafe" not in policy
            assert page.headers["x-content-type-options"] == "nosniff"

    @pytest.mark.parametrize("token", ["", "0" * 32, "x", "\u00fc"])
    @pytest.mark.parametrize("path", ["/", "/api/jobs", "/static/index.html", "/api/events", "/api/nothing"])
    def test_nothing_is_told_without_the_token(self, served: Served, path: str, token: str) -> None:
        refused(asked(served, path=path), 401)
        own = {"Cookie": f"intarsia-{served.port}={token}", "Sec-Fetch-Site": "none"}
        refused(asked(served, path=path, **own), 401)
        refused(asked(served, path=path, Authorization=f"Bearer {token or 0}"), 401)
        for name in ("token", "enter"):
            refused(httpx.get(served.address.rstrip("/") + path, params={name: token or served.token}), 401)

    @pytest.mark.parametrize(
        "host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:{}", "[::1]:{}", "0.0.0.0:{}", ""]
    )
    def test_another_host_is_refused(self, served: Served, host: str) -> None:
        own = {"Authorization": f"Bearer {served.token}"}
        refused(asked(served, Host=host.format(served.port), **own), 400, 403)
        assert asked(served, Host=f"localhost:{served.port}", **own).status_code == 200

    @pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1:{}"])
    @pytest.mark.parametrize("method", ["GET", "POST"])
    def test_another_origin_is_refused(self, served: Served, origin: str, method: str) -> None:
        own = {"Authorization": f"Bearer {served.token}", "X-Intarsia": "1"}
        refused(asked(served, method, Origin=origin.format(served.port), **own), 403)

    def test_a_change_needs_the_header_and_no_other_site(self, served: Served) -> None:
        own = {"Authorization": f"Bearer {served.token}"}
        refused(asked(served, "POST", **own), 403)
        refused(asked(served, "DELETE", "/api/jobs/0", **own), 403)
        refused(asked(served, "POST", **own, **{"X-Intarsia": "1", "Sec-Fetch-Site": "cross-site"}), 403)

    @pytest.mark.parametrize("site", ["cross-site", "same-site"])
    def test_what_other_pages_embed_is_refused(self, served: Served, site: str) -> None:
        """A page of another port of the same host is of the same site: cookies come with what it asks for."""
        own = {"Cookie": entered(served), "Sec-Fetch-Site": site}
        code = served.entrance().partition("?")[2]
        for path in ("/", "/api/jobs", "/static/index.html", "/api/events", f"/?{code}"):
            refused(asked(served, path=path, **own, **{"Sec-Fetch-Mode": "no-cors"}), 403)
        refused(asked(served, path="/api/jobs", **own, **{"Sec-Fetch-Mode": "navigate"}), 403)
        assert asked(served, path=f"/?{code}", **own, **{"Sec-Fetch-Mode": "navigate"}).status_code == 200
        assert asked(served, **own | {"Sec-Fetch-Site": "none"}).status_code == 200

    def test_an_entrance_lets_one_browser_in_once(self, served: Served) -> None:
        code, typed = served.entrance().partition("?")[2], {"Sec-Fetch-Site": "none", "Sec-Fetch-Mode": "navigate"}
        assert asked(served, "HEAD", f"/?{code}", **typed).status_code == 401
        first = asked(served, path=f"/?{code}", **typed)
        assert first.status_code == 200
        own = typed | {"Cookie": first.headers["set-cookie"].partition(";")[0]}
        assert "printed last" in refused(asked(served, path=f"/?{code}", **typed), 401)
        assert asked(served, path=f"/?{code}", **own).status_code == 200  # the same browser: a reload, a second tab
        assert asked(served, path="/", **own).status_code == 200

    def test_a_cookie_alone_is_worth_nothing_to_others(self, served: Served) -> None:
        """Other ports of the host may see it; it is not the token, and serves the page alone."""
        cookie = entered(served)
        assert served.token not in cookie
        refused(asked(served, Cookie=cookie), 401)
        refused(asked(served, Authorization=f"Bearer {cookie.partition('=')[2]}"), 401)
        refused(asked(served, Cookie=cookie.partition("=")[0] + "=" + served.token, **{"Sec-Fetch-Site": "none"}), 401)
        assert asked(served, Cookie=cookie, **{"Sec-Fetch-Site": "same-origin"}).status_code == 200

    @pytest.mark.skipif(sys.platform != "linux", reason="other systems have one address of loopback")
    def test_the_page_has_a_host_of_its_own(self, served: Served, tmp_path: Path) -> None:
        """A browser sends cookies to all ports of a host: no other server has this one. It stays with the folder."""
        hosts = [served.host]
        for _ in range(2):
            with studio(tmp_path / "folder") as other:
                hosts.append(other.address)
        assert hosts[1] == hosts[2]
        assert all(host.startswith("127.") for host in hosts[:1])
        assert len({*hosts, "127.0.0.1"}) == 3

    def test_a_length_told_in_two_ways_is_refused(self, served: Served) -> None:
        head = f"POST /api/jobs HTTP/1.1\r\nHost: {served.host}:{served.port}\r\nX-Intarsia: 1\r\n"
        head += f"Authorization: Bearer {served.token}\r\nContent-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n"
        with socket.create_connection((served.host, served.port), 10) as line:
            line.sendall(head.encode() + b"2\r\n{}\r\n0\r\n\r\n")
            answer = b"".join(iter(lambda: line.recv(4096), b""))
        assert answer.startswith(b"HTTP/1.1 400 ")
        assert b"two ways" in answer

    def test_no_other_page_is_allowed_to_read(self, served: Served) -> None:
        answer = served.client.get("/api/jobs")
        assert not [name for name in answer.headers if name.startswith("access-control")]
        refused(served.client.request("OPTIONS", "/api/jobs"), 405)
        refused(served.client.request("TRACE", "/api/jobs"), 405)


NAMES = (
    "../../studio.sqlite", "..%2f..%2fstudio.sqlite", "%2e%2e/%2e%2e/studio.sqlite", "/etc/passwd", "%2fetc%2fpasswd",
    "C:%5cwindows%5cwin.ini", "..%5c..%5cstudio.sqlite", "a%00.png", ".told.json", "%252e%252e%252fstudio.sqlite", "~",
)  # fmt: skip


class TestNames:
    @pytest.mark.parametrize("name", NAMES)
    def test_no_name_leads_out(self, served: Served, small: str, name: str) -> None:
        result = served.done("grow", [small], **QUICK)["id"]
        for path in (
            f"/api/results/{result}/files/{name}", f"/api/results/{name}", f"/api/exemplars/{name}",
            f"/api/exemplars/{small}/{name}.png", f"/static/{name}", f"/api/samples/{name}.png", f"/{name}",
            f"/api/results/{result}/view/{name}.png", f"/api/jobs/{name}", f"/api/weaves/{name}/0/0/0.png",
        ):  # fmt: skip
            raw = httpx.URL(served.address).copy_with(raw_path=path.encode())
            answer = served.client.request("GET", raw)
            if answer.status_code == 200:  # a path that was shortened to one that is there
                assert answer.headers["content-type"].startswith(("text/html", "application/json"))
                assert b"SQLite" not in answer.content
                assert b"root:" not in answer.content
            else:
                refused(answer)

    @pytest.mark.parametrize(
        "name",
        ["../../up.png", "/etc/up.png", "C:\\up.png", "a\0b.png", "..", ".hidden", "-leading.png", "", "x" * 500],
    )
    def test_names_of_uploads_are_made_here(self, served: Served, name: str) -> None:
        answer = served.client.post("/api/exemplars", files=[("files", (name, png(pixels(seed=5)), "image/png"))])
        if not name:
            refused(answer, 400)
            return
        row = answer.json()
        kept = [path for path in (served.folder / "exemplars" / row["id"]).iterdir() if path.name != ".told.json"]
        assert len(kept) == 1
        assert kept[0].suffix == ".png"
        assert not kept[0].name.startswith((".", "-"))
        assert len(kept[0].name) <= 64
        assert not list(served.folder.glob("up*"))

    def test_what_is_kept_of_a_name(self) -> None:
        names = ("a b.png", "../x/y.tar.gz", "-o.png", "...", "Moos_2-b.PNG", "木.png")
        found = [uploads.stem_of(name) for name in names]
        assert found == ["a_b", "y_tar", "o", "picture", "Moos_2-b", "木"]


class TestJobs:
    @pytest.mark.parametrize(
        ("options", "said"),
        [
            ({"output": "/tmp/x.png"}, "output"), ({"o": "x.png"}, "o"), ({"save_map": "x.npz"}, "save_map"),
            ({"report": "x.html"}, "report"), ({"sheet": "x.png"}, "sheet"), ({"map": "height=/etc/passwd"}, "map"),
            ({"force": True}, "force"), ({"max_pixels": 1}, "max_pixels"), ({"threads": 4}, "threads"),
            ({"mask": "/etc/passwd"}, "mask"), ({"mask": ["alpha"]}, "mask"), ({"mask": "-"}, "mask"),
            ({"jitter_output": "/etc/passwd"}, "an image's id"), ({"jitter_output": "-"}, "an image's id"),
            ({"feature": "../../studio.sqlite"}, "feature"), ({"debug": True}, "debug"), ({"json": True}, "json"),
            ({"nonsense": 1}, "nonsense"), ({"../x": 1}, "x"), ({"size": "0"}, "size"), ({"size": "9x9x9"}, "size"),
            ({"size": {"a": 1}}, "size"), ({"size": "9" * 20_000}, "size"), ({"seed": "5\n--force"}, "seed"),
            ({"patch": "nan"}, "patch"), ({"patch": True}, "patch"), ({"method": "magic"}, "method"),
            ({"seed": -1}, "seed"), ({"crop": "1,2"}, "crop"), ({"flatten": "yes"}, "flatten"),
            ({"weight": ["a=1"] * 500}, "weight"), ({"gate": "/etc/passwd"}, "gate"),
        ],
    )  # fmt: skip
    def test_an_option_that_is_none_of_its_own_is_refused(
        self, served: Served, small: str, options: dict[str, Any], said: str
    ) -> None:
        before = len(served.get("/api/jobs"))
        answer = served.client.post("/api/jobs", json={"verb": "grow", "exemplars": [small], "options": options})
        assert said.strip("./") in refused(answer, 400)
        assert len(served.get("/api/jobs")) == before

    def test_a_refusal_names_the_option_as_it_is_called_here(self, served: Served, small: str) -> None:
        asked = {"verb": "grow", "exemplars": [small], "options": {"size": "65000x65000"}}
        assert refused(served.client.post("/api/jobs", json=asked), 400).startswith("size: 65000x65000 is not allowed;")

    @pytest.mark.parametrize(
        "job",
        [
            {"verb": "warm-up", "exemplars": [], "options": {}}, {"verb": "../grow", "exemplars": []}, {"verb": 3}, {},
            {"verb": "grow", "exemplars": []}, {"verb": "grow", "exemplars": ["/etc/passwd"]}, [], "grow", None,
            {"verb": "grow", "exemplars": ["0" * 16]}, {"verb": "grow", "exemplars": "x"}, {"verb": "heal"},
            {"verb": "grow", "exemplars": ["sample:stones"]}, {"verb": "grow", "exemplars": [["x"]]},
            {"verb": "render", "options": {"map": "../map.npz"}}, {"verb": "grow", "words": ["--force"]},
            {"verb": "grow", "label": "x" * 300}, {"verb": "grow", "options": []},
        ],
    )  # fmt: skip
    def test_a_job_that_is_none_is_refused(self, served: Served, job: Any) -> None:
        refused(served.client.post("/api/jobs", json=job), 400)

    @pytest.mark.parametrize("body", [b"", b"{", b"[" * 100_000, b"\xff\xfe", b'{"verb": NaN}'])
    def test_what_is_no_json_is_refused(self, served: Served, body: bytes) -> None:
        for path in ("/api/jobs", "/api/weaves", "/api/exemplars"):
            refused(served.client.post(path, content=body), 400)

    def test_every_option_that_reads_or_writes_a_file_is_known(self) -> None:
        for verb in requests.VERBS:
            offered = requests.options(verb)
            written = {"output", "map", "save_map", "sheet", "report", "preview"}
            assert not set(offered) & written
            read = [p for p in roles.command(verb).params if isinstance(p, click.Option) and roles.names_a_file(p)]
            named = [name for p in read if (name := max(p.opts, key=len)[2:].replace("-", "_")) in offered]
            assert named
            assert all(offered[name]["kind"] in ("image", "exemplar", *OVER) for name in named), named


class TestLimits:
    def test_a_body_over_the_limit_is_refused(self, served: Served) -> None:
        large = b" " * (requests.LIMITS["json"] + 1)
        refused(served.client.post("/api/jobs", content=large), 413)

        def slowly() -> Any:
            for _ in range(20):
                yield b" " * (1 << 17)

        refused(served.client.post("/api/jobs", content=slowly()), 413)
        head = f"POST /api/images HTTP/1.1\r\nHost: {served.host}:{served.port}\r\nX-Intarsia: 1\r\n"
        head += f"Authorization: Bearer {served.token}\r\nContent-Length: {1 << 40}\r\n\r\n"
        with socket.create_connection((served.host, served.port), 10) as line:
            line.sendall(head.encode())
            assert line.recv(4096).startswith(b"HTTP/1.1 413 ")

    def test_too_many_files_are_refused(self, served: Served) -> None:
        many = [("files", (f"a{n}.png", b"x")) for n in range(requests.LIMITS["files"] + 1)]
        refused(served.client.post("/api/exemplars", files=many), 400)

    @pytest.mark.parametrize("side", ["0", "-1", "99999", "1e3", "x", "\u0663", ""])
    def test_a_size_that_is_none_is_refused(self, served: Served, small: str, side: str) -> None:
        refused(served.client.get(f"/api/exemplars/{small}/albedo.png", params={"side": side}), 400)


BAD = sorted(
    name for name, case in CASES.items()
    if case.outcome in (REFUSED, OK) and name.partition(".")[0] not in ("a device", "a pipe") and "." in name
)  # fmt: skip


@pytest.mark.parametrize("part", range(4))
def test_uploads_of_the_corpus_are_read_or_refused(
    served: Served, tmp_path: Path, part: int, thorough: bool
) -> None:
    """None of them ends the server, takes long, or is told with a place."""
    for name in BAD[part :: 4 if thorough else 16]:
        case = CASES[name]
        (tmp_path / name.replace("/", "_")).mkdir()
        path = case.make(tmp_path / name.replace("/", "_"))
        if not path.is_file():
            continue
        began = time.monotonic()
        answer = served.client.post("/api/exemplars", files=[("files", (path.name, path.read_bytes()))])
        assert time.monotonic() - began < 20, name
        if answer.status_code == 201:
            assert case.outcome == OK, name
            served.client.delete(f"/api/exemplars/{answer.json()['id']}")
        else:
            refused(answer, 400)
    assert served.get("/api/schema")


def _peak(pid: int) -> int:
    """The most memory that a process ever had, bytes."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("VmHWM"))


def test_images_of_numbers_are_png_of_one_channel(served: Served, tmp_path: Path) -> None:
    assert served.post("/api/jobs", {}, 400)
    bomb = tmp_path / "bomb.png"
    bomb.write_bytes(CASES["bomb.png"].make(tmp_path).read_bytes())
    for data in (b"", b"x", png(pixels()), (b"GIF89a" + bytes(20)), png(pixels())[:80], bomb.read_bytes()):
        refused(served.client.post("/api/images", content=data), 400)
    before = sum(map(_peak, children(served.process.pid)))
    refused(served.client.post("/api/images", content=bomb.read_bytes()), 400)
    assert sum(map(_peak, children(served.process.pid))) < before + (200 << 20)
    assert not list((served.folder / "images").glob(".under-way-*"))


def test_the_server_imports_nothing_that_decodes() -> None:
    """Pictures are touched in the processes beside alone."""
    script = """
import sys
from intarsia.studio import requests, serving
requests.schema()
print(sorted({"numpy", "PIL", "OpenImageIO", "scipy", "numba", "skimage"} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "[]", done.stderr


def test_the_process_that_decodes_has_limits(served: Served, small: str) -> None:
    served.bytes(f"/api/exemplars/{small}/albedo.png?side=31")
    limited = []
    for pid in children(served.process.pid):
        for line in Path(f"/proc/{pid}/limits").read_text().splitlines():
            if line.startswith("Max address space") and line.split()[3] == str(uploads.MOST_BYTES):
                limited.append(pid)
    assert len(limited) == 1


def test_the_schema_is_json(served: Served) -> None:
    assert json.loads(served.bytes("/api/schema")) == json.loads(json.dumps(requests.schema()))
