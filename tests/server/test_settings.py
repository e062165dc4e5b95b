import os
from pathlib import Path

import pytest

from seamark.server.settings import Settings, SettingsInvalid


def _load(tmp_path: Path, **variables: str) -> Settings:
    return Settings.load({"SEAMARK_DATA": str(tmp_path)} | variables)


def test_without_environment_variables_the_service_is_local(tmp_path: Path) -> None:
    settings = _load(tmp_path)

    assert settings.database_url == f"sqlite:///{tmp_path}/seamark.db"
    assert (settings.host, settings.public) == ("127.0.0.1", False)
    assert settings.sandbox_min_level == "medium"
    assert settings.workers == len(os.sched_getaffinity(0))


def test_a_public_service_requires_strong_isolation_unless_configured_otherwise(
    tmp_path: Path,
) -> None:
    assert _load(tmp_path, SEAMARK_PUBLIC="true").sandbox_min_level == "strong"
    configured = _load(tmp_path, SEAMARK_PUBLIC="1", SEAMARK_SANDBOX_MIN_LEVEL="medium")
    assert configured.sandbox_min_level == "medium"


def test_the_secret_key_is_generated_once_and_only_its_owner_can_read_it(tmp_path: Path) -> None:
    first, second = _load(tmp_path), _load(tmp_path)

    assert first.secret_key == second.secret_key
    assert len(first.secret_key) >= 32
    assert (tmp_path / "secret").stat().st_mode & 0o777 == 0o600
    assert first.secret_key not in repr(first)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["secret", "seed_key"]


def test_a_new_service_draws_the_key_of_its_seeds_apart_from_the_secret_key(tmp_path: Path) -> None:
    first, second = _load(tmp_path / "new"), _load(tmp_path / "new")

    assert first.seed_key == second.seed_key != first.secret_key
    assert (tmp_path / "new" / "seed_key").stat().st_mode & 0o777 == 0o600
    assert first.seed_key not in repr(first)


def test_a_value_can_be_read_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "url").write_text("redis://there:6379/1\n")

    settings = _load(tmp_path, SEAMARK_BROKER_URL_FILE=str(tmp_path / "url"))

    assert settings.broker_url == "redis://there:6379/1"


@pytest.mark.parametrize("content", ["", " \n"])
@pytest.mark.parametrize("name", ["SECRET_KEY", "SEED_KEY", "STORAGE_SECRET_KEY", "BROKER_URL"])
def test_an_empty_file_of_a_setting_is_refused_by_its_name_and_nothing_is_drawn(
    tmp_path: Path, name: str, content: str
) -> None:
    file = tmp_path / "given"
    file.write_text(content)

    with pytest.raises(SettingsInvalid, match=f"SEAMARK_{name}_FILE: {file} is empty"):
        _load(tmp_path / "data", **{f"SEAMARK_{name}_FILE": str(file)})

    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("name", ["SECRET_KEY", "SEED_KEY", "METRICS_TOKEN", "MAIL_URL"])
def test_an_empty_variable_of_a_secret_is_refused_by_its_name(tmp_path: Path, name: str) -> None:
    with pytest.raises(SettingsInvalid, match=f"SEAMARK_{name} is empty"):
        _load(tmp_path, **{f"SEAMARK_{name}": ""})


@pytest.mark.parametrize("name", ["secret", "seed_key"])
def test_an_empty_key_in_the_data_folder_is_refused_with_what_to_do(
    tmp_path: Path, name: str
) -> None:
    _load(tmp_path)
    (tmp_path / name).write_text("\n")

    for looking in (False, True):
        with pytest.raises(SettingsInvalid, match=rf"{name} is empty\. .*[Dd]elete it"):
            Settings.load({"SEAMARK_DATA": str(tmp_path)}, looking=looking)

    assert (tmp_path / name).read_text() == "\n"


def test_who_only_looks_draws_no_keys_and_makes_no_folder(tmp_path: Path) -> None:
    environ = {"SEAMARK_DATA": str(tmp_path / "new")}

    looking = Settings.load(environ, looking=True)
    assert (looking.secret_key, looking.seed_key) == ("", "")
    assert not (tmp_path / "new").exists()

    drawn = Settings.load(environ)
    assert Settings.load(environ, looking=True) == drawn


@pytest.mark.parametrize(
    ("variables", "says"),
    [
        ({"SEAMARK_PROT": "80"}, "SEAMARK_PROT"),
        ({"SEAMARK_PORT": "eighty"}, "SEAMARK_PORT"),
        ({"SEAMARK_PORT": "70000"}, "65535"),
        ({"SEAMARK_WORKERS": "0"}, "SEAMARK_WORKERS"),
        ({"SEAMARK_SANDBOX_MIN_LEVEL": "total"}, "strong"),
        ({"SEAMARK_RANKED_TRIALS": "5"}, "no longer a setting: each benchmark says"),
        ({"SEAMARK_METRICS": "off"}, "no longer a setting: others"),
        ({"SEAMARK_SECRET_KEY_FILE": "/nothing/here"}, "cannot be read"),
    ],
)
def test_an_invalid_or_unknown_setting_is_refused_with_a_message(
    tmp_path: Path, variables: dict[str, str], says: str
) -> None:
    with pytest.raises(SettingsInvalid, match=says):
        _load(tmp_path, **variables)


def test_a_child_process_loads_the_same_settings(tmp_path: Path) -> None:
    settings = _load(tmp_path, SEAMARK_PORT="81", SEAMARK_PUBLIC="true")

    assert Settings.load(settings.environment()) == settings


@pytest.mark.parametrize(
    "origins", ["*", "https://a.org/path", "a.org", "https://a.org; x", "'self'"]
)
def test_only_origins_may_embed(origins: str) -> None:
    with pytest.raises(SettingsInvalid, match="EMBED_ORIGINS"):
        Settings.load({"SEAMARK_EMBED_ORIGINS": origins})


MAIL = {"SEAMARK_MAIL_FROM": "Seamark <a@b.example>", "SEAMARK_URL": "https://b.example"}
SMTP = "smtp://user:pass%40word@mail.example:587"
PROVIDER = {
    "SEAMARK_OIDC_ISSUER": "https://id.example/realms/x",
    "SEAMARK_OIDC_CLIENT_ID": "seamark",
    "SEAMARK_OIDC_CLIENT_SECRET": "hidden",
    "SEAMARK_URL": "https://b.example",
}


@pytest.mark.parametrize(
    "url", [SMTP, f"{SMTP}?tls=starttls", "smtps://mail.example", "smtp://10.0.0.1:25?tls=none"]
)
def test_a_mail_server_is_set_by_a_url_whose_password_is_not_shown(
    tmp_path: Path, url: str
) -> None:
    settings = _load(tmp_path, SEAMARK_MAIL_URL=url, **MAIL)

    assert settings.mail_url == url
    assert "pass" not in repr(settings)


@pytest.mark.parametrize(
    "variables",
    [
        MAIL | {"SEAMARK_MAIL_URL": "smtp://user:secret@mail.example?tls=none"},
        MAIL | {"SEAMARK_MAIL_URL": "http://mail.example"},
        MAIL | {"SEAMARK_MAIL_URL": "smtp://mail.example\n"},
        MAIL | {"SEAMARK_MAIL_FROM": "a@b.c\nBcc: d@e.f"},
        {"SEAMARK_MAIL_URL": SMTP, "SEAMARK_URL": "https://b.example"},
        {"SEAMARK_MAIL_URL": SMTP, "SEAMARK_MAIL_FROM": "a@b.c"},
        PROVIDER | {"SEAMARK_OIDC_CLIENT_SECRET": ""},
        PROVIDER | {"SEAMARK_URL": ""},
        PROVIDER | {"SEAMARK_OIDC_ISSUER": "http://id.example", "SEAMARK_PUBLIC": "true"},
        PROVIDER | {"SEAMARK_OIDC_ISSUER": "javascript:alert(1)"},
    ],
    ids=str,
)
def test_mail_and_identity_provider_are_set_completely_or_not_at_all(
    tmp_path: Path, variables: dict[str, str]
) -> None:
    with pytest.raises(SettingsInvalid) as refused:
        _load(tmp_path, **variables)

    assert "secret@" not in str(refused.value)


def test_who_may_sign_up_by_the_provider_is_as_for_others_unless_it_is_set(tmp_path: Path) -> None:
    same = _load(tmp_path, SEAMARK_SIGN_UP="closed", **PROVIDER)
    own = _load(tmp_path, SEAMARK_SIGN_UP="closed", SEAMARK_OIDC_SIGN_UP="open", **PROVIDER)

    assert (same.oidc_sign_up, own.oidc_sign_up) == ("closed", "open")
    assert "hidden" not in repr(own)
