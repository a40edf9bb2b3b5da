"""What an operator can set, read once from the environment (`EXOGAUGE_…`)."""

from __future__ import annotations

from ipaddress import ip_address
from pathlib import Path
from typing import Annotated, Literal, Self, final
from urllib.parse import urlsplit

from pydantic import Field, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from exogauge.errors import BadInput, Fault

MIB = 1024 * 1024


@final
class Settings(BaseSettings):
    """One installation. Every field can be set as `EXOGAUGE_<NAME>`; the defaults serve one person on one machine."""

    model_config = SettingsConfigDict(env_prefix="EXOGAUGE_", frozen=True, extra="forbid")

    data_dir: Path = Field(default=Path("exogauge-data"), description="everything the service keeps, unless said below")
    database_url: str = Field(
        default="", repr=False, description="sqlite:///FILE or postgresql://…; a file in data_dir"
    )
    blob_dir: Path | None = Field(default=None, description="content-addressed files; data_dir/blobs")
    blob_url: str = Field(
        default="", pattern=r"^(s3://.+)?$", description="s3://BUCKET/FOLDER: an S3 store, in place of blob_dir"
    )
    s3_endpoint: str = Field(default="", pattern=r"^(https?://.+)?$", description="of a store that is not Amazon's")
    s3_region: str = Field(default="", description="of the store; AWS_REGION")
    s3_access_key_id: str = Field(default="", repr=False, description="or as AWS_ACCESS_KEY_ID")
    s3_secret_access_key: str = Field(default="", repr=False, description="or as AWS_SECRET_ACCESS_KEY")
    blob_copies_bytes: int = Field(
        default=10240 * MIB, ge=MIB, description="most that this machine keeps of an S3 store's files, to read them"
    )
    host: str = Field(default="127.0.0.1", description="address to listen on")
    accounts: bool = Field(default=False, description="ask who is there; so it is anyway once there are accounts")
    proxy: str = Field(default="", description="addresses of reverse proxies that are believed, with commas between")
    tls_certificate: Path | None = Field(default=None, description="PEM, with which the server encrypts by itself")
    tls_key: Path | None = Field(default=None, description="PEM, of that certificate")
    open_to_all: bool = Field(default=False, description="serve on another host than this one although all may do all")
    port: int = Field(default=8765, ge=0, le=65535, description="port to listen on; 0 takes a free one")
    root_path: str = Field(default="", description="sub-path under which a reverse proxy serves the page")
    public_url: str = Field(
        default="",
        pattern=r"^(https?://[^/?#\s]+[^?#\s]*[^/?#\s])?$",
        description="address by which others find the page, https://exo.example; unset: that by which "
        "each request came",
    )
    oidc_issuer: str = Field(default="", max_length=300, description="OpenID provider at which accounts sign in, https")
    oidc_client_id: str = Field(default="", max_length=300, description="of this service, as registered there")
    oidc_client_secret: str = Field(default="", repr=False, description="the provider's, for this service")
    oidc_name: str = Field(default="", max_length=60, description="of the provider, on the page; its host")
    webhook_private_hosts: str = Field(
        default="",
        description="names to which webhooks may go although their addresses are private, with commas between",
    )
    workers: int = Field(default=2, ge=0, le=64, description="worker processes started with the server; 0: elsewhere")
    max_connections: int = Field(default=256, ge=8, description="at once; one that waits without a request gives way")
    silence_s: float = Field(default=30.0, gt=0.0, description="within a request or stream, after which it is given up")
    max_live_streams: int = Field(default=8, ge=0, le=64, description="live streams at once, a process each")
    readers: int = Field(default=4, ge=1, le=64, description="uploads read at once, each by a child of up to 4 GiB")
    requests_per_s: float = Field(default=100.0, ge=0.0, description="of one address in the mean; 0: no limit")
    metrics: bool | None = Field(
        default=None, description="whether /metrics answers; unset: where this server listens on this machine alone"
    )
    log: Literal["words", "json"] = Field(default="words", description="what a line of the log is")
    lab_bytes: int = Field(default=0, ge=0, description="most that a lab may keep, as handed in and made; 0: no limit")
    lab_jobs: int = Field(default=1000, ge=0, description="most jobs of a lab that wait or run; 0: no limit")
    lab_cpu_s_per_day: float = Field(default=0.0, ge=0.0, description="that jobs of a lab may compute; 0: no limit")
    lab_kept_days: float = Field(default=30.0, ge=0.0, description="for which a closed lab can be opened again")
    deliveries_kept_days: float = Field(default=30.0, ge=0.0, description="that a webhook's are told; 0: always")
    job_logs_kept_days: float = Field(default=0.0, ge=0.0, description="after a job ended, with its steps; 0: always")
    unused_logs_kept_days: float = Field(
        default=0.0, ge=0.0, description="of what was uploaded as a log and is in no study and no payload; 0: always"
    )
    studies_kept_days: dict[str, Annotated[float, Field(ge=1.0)]] = Field(
        default_factory=dict,
        description='by lab, {"LAB": DAYS}: its studies go with jobs and results so long after they were last worked '
        "with; labs that are not named keep all",
    )
    audit_kept_days: float = Field(
        default=3650.0,  # as long as research data are usually kept (DFG, Good Research Practice, guideline 17)
        ge=30.0,
        description="from which age on `exogauge audit` takes entries of the audit; the service removes none",
    )
    max_upload_bytes: int = Field(default=2048 * MIB, ge=1024, description="largest request body")
    max_bundle_bytes: int = Field(default=8192 * MIB, ge=1024, description="largest bundle once unpacked")
    upload_kept_hours: float = Field(default=168.0, gt=0.0, description="after which an untouched upload is removed")
    max_bundle_files: int = Field(default=1000, ge=1, description="most files in one bundle")
    max_description_bytes: int = Field(default=MIB, ge=1024, description="largest study.yaml, robot.yaml, device.yaml")
    lab: str = Field(
        default="local",
        min_length=1,
        max_length=64,
        description="the lab whose requests this server serves; workers serve all",
    )

    @model_validator(mode="after")
    def _fill_places(self) -> Self:
        data = self.data_dir.expanduser().absolute()
        object.__setattr__(self, "data_dir", data)
        object.__setattr__(self, "blob_dir", (self.blob_dir or data / "blobs").expanduser().absolute())
        if not self.database_url:
            object.__setattr__(self, "database_url", f"sqlite:///{data / 'exogauge.sqlite'}")
        return self

    @model_validator(mode="after")
    def _check_provider(self) -> Self:
        if not self.oidc_issuer:
            return self
        parts = urlsplit(self.oidc_issuer)
        if parts.scheme != "https" and not (parts.scheme == "http" and is_loopback(parts.hostname or "")):
            raise ValueError("EXOGAUGE_OIDC_ISSUER is an https address")
        if not self.oidc_client_id:
            raise ValueError("EXOGAUGE_OIDC_CLIENT_ID belongs to EXOGAUGE_OIDC_ISSUER")
        object.__setattr__(self, "oidc_name", self.oidc_name or parts.hostname or "")
        return self

    @property
    def blobs(self) -> Path:
        """Folder of the blob store, absolute."""
        assert self.blob_dir is not None
        return self.blob_dir

    @property
    def blob_copies(self) -> Path:
        """Folder of what this machine has fetched from an S3 store."""
        return self.data_dir / "blob-copies"

    @property
    def scratch(self) -> Path:
        """Folder for what is being received or unpacked: one folder per process; nothing in it outlives that."""
        return self.data_dir / "scratch"

    @property
    def work(self) -> Path:
        """Folder of what workers compute: one folder per worker."""
        return self.data_dir / "work"

    @property
    def live(self) -> Path:
        """Folder of open live streams: one folder per stream."""
        return self.data_dir / "live"

    @property
    def uploads(self) -> Path:
        """Folder of resumable uploads that are not yet used or given up."""
        return self.data_dir / "uploads"

    @property
    def private_webhooks(self) -> frozenset[str]:
        """Names to which webhooks may go although their addresses are private, in small letters."""
        return frozenset(name.strip().casefold() for name in self.webhook_private_hosts.split(",") if name.strip())

    @property
    def set_up_code(self) -> Path:
        """File with what proves, at the first account, that one runs this server."""
        return self.data_dir / "set-up-code"

    @property
    def encrypts(self) -> bool:
        return self.tls_certificate is not None

    @property
    def local_only(self) -> bool:
        """Whether nobody but this machine reaches the server: it listens on the loopback interface, for no proxy."""
        if self.proxy:
            return False
        return is_loopback(self.host)


def refuse_open_house(settings: Settings) -> None:
    """A network is served with accounts, over an encrypted line; without either only on purpose."""
    if (settings.tls_certificate is None) != (settings.tls_key is None):
        advice = "Name both files, or neither."
        raise BadInput(Fault("a certificate and its key belong together", "tls", advice, column="EXOGAUGE_TLS_KEY"))
    if settings.open_to_all and settings.accounts:
        detail = "either there are accounts, or all may do all"
        raise BadInput(Fault(detail, "open_to_all", "Leave one of the two.", column="EXOGAUGE_OPEN_TO_ALL"))
    if settings.local_only or settings.open_to_all:
        return
    ways = "Leave EXOGAUGE_HOST at 127.0.0.1, or "
    if not settings.accounts:
        detail = f"without accounts, whoever reaches {settings.host} could read, change and delete everything"
        guarded = "or EXOGAUGE_OPEN_TO_ALL=1 where something in front lets in only yours."
        advice = f"{ways}say EXOGAUGE_ACCOUNTS=1, {guarded}"
        raise BadInput(Fault(detail, "no_accounts", advice, column="EXOGAUGE_HOST", value=settings.host))
    if not (settings.encrypts or settings.proxy):
        detail = f"passwords and data would pass to {settings.host} unencrypted"
        advice = (
            f"{ways}name EXOGAUGE_TLS_CERTIFICATE and EXOGAUGE_TLS_KEY, or in EXOGAUGE_PROXY the proxy that encrypts."
        )
        raise BadInput(Fault(detail, "no_encryption", advice, column="EXOGAUGE_HOST", value=settings.host))


def is_loopback(host: str) -> bool:
    """Whether it is this machine, seen from itself."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


IN_CHECKOUT = {"web": "web/dist"}


def packaged_folder(name: str) -> Path:
    """A folder that ships with the code: `exogauge/_packaged/<name>` in a wheel, and in a checkout the top-level
    folder or what was built from it.

    FileNotFoundError: neither is there.
    """
    package = Path(__file__).resolve().parent
    for folder in (package / "_packaged" / name, package.parents[1] / IN_CHECKOUT.get(name, name)):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the folder {name!r} is neither packaged with exogauge nor in a source checkout")
