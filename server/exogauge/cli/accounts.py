"""Commands of who may do what: sign in from a terminal; accounts, for whoever runs the service."""

from __future__ import annotations

import argparse
import getpass
import os
import sys

from exogauge.cli.endings import Commands

HERE = "http://127.0.0.1:8765"


def add_commands(commands: Commands) -> None:
    """Sign in, sign out, accounts."""
    login = commands.add_parser("login", help="keep a token for a service, so that commands and scripts may use it")
    login.add_argument("url", nargs="?", default=os.environ.get("EXOGAUGE_URL", HERE), help=f"default {HERE}")
    login.add_argument("--email", help="of your account; asked for where it is not given")
    login.add_argument("--lab", help="name of the lab, where you are of several")
    login.add_argument("--read-only", action="store_true", help="a token that changes nothing")
    login.add_argument("--days", type=int, default=90, help="until it ends (default 90)")
    login.add_argument("--token", action="store_true", help="paste a token that the page made, such as a robot's")
    login.set_defaults(command=sign_in)

    logout = commands.add_parser("logout", help="forget the token of a service; revoke it on the page `Account`")
    logout.add_argument("url", nargs="?", default=os.environ.get("EXOGAUGE_URL", HERE), help=f"default {HERE}")
    logout.set_defaults(command=sign_out)

    account = commands.add_parser("account", help="accounts of this installation; for who runs it, beside its database")
    account.set_defaults(command=list_accounts)
    what = account.add_subparsers(dest="what", metavar="WHAT")
    add = what.add_parser("add", help="an account, with a role in a lab, which is founded where there is none")
    add.add_argument("email")
    add.add_argument("--name", help="of the person")
    add.add_argument("--lab", help="its name; default: the lab whose data are there")
    add.add_argument("--role", choices=("viewer", "member", "admin"), default="member")
    add.add_argument("--operator", action="store_true", help="may found labs")
    add.set_defaults(command=add_account)
    for name, said in (("password", "a new password"), ("lock", "let nobody in by it"), ("unlock", "let it in again")):
        one = what.add_parser(name, help=said)
        one.add_argument("email")
        one.set_defaults(command=change_account)

    lab = commands.add_parser("lab", help="labs of this installation; for who runs it, beside its database")
    lab.set_defaults(command=list_labs)
    deed = lab.add_subparsers(dest="what", metavar="WHAT")
    for name, said in (
        ("close", "nobody comes in any more; after EXOGAUGE_LAB_KEPT_DAYS all of it goes but what it has published"),
        ("reopen", "let its members in again, while it is there"),
    ):
        one = deed.add_parser(name, help=said)
        one.add_argument("lab", help="its name")
        one.set_defaults(command=change_lab)
    retract = deed.add_parser("retract", help="revoke what a lab has published that is gone; its address tells why")
    retract.add_argument("key", help="the last part of the permalink")
    retract.add_argument("--because", required=True, metavar="REASON", help="told to whoever follows the link")
    retract.set_defaults(command=retract_publication)


def sign_in(options: argparse.Namespace) -> int:
    from exogauge.client import Client
    from exogauge.client.tokens import keep, token_by_password

    if options.token:
        token = secret("Token: ").strip()
    else:
        email = options.email or input("E-mail: ")
        scope = "read" if options.read_only else "write"
        token = token_by_password(options.url, email, secret("Password: "), scope, options.lab, options.days)
    with Client(options.url, token=token) as client:
        found = client.session()
    print(f"signed in to {options.url}, lab {(found.get('lab') or {}).get('name')}; kept in {keep(options.url, token)}")
    return 0


def sign_out(options: argparse.Namespace) -> int:
    from exogauge.client.tokens import keep

    print(f"forgotten in {keep(options.url, None)}")
    return 0


def list_accounts(_: argparse.Namespace) -> int:
    from exogauge.jobs.schema import prepare
    from exogauge.settings import Settings
    from exogauge.storage.accounts import Accounts
    from exogauge.storage.store import open_installation
    from exogauge.terminal import text_table

    settings = Settings()
    prepare(settings)
    with open_installation(settings).reading() as session:
        accounts = Accounts(session)
        rows = [
            [
                each.email,
                each.name,
                ", ".join(f"{lab.name} ({role})" for lab, role in accounts.labs_of(each.id)),
                "locked" if each.disabled_at else "operator" if each.operator else "",
            ]
            for each in accounts.all()
        ]
    print(text_table(("e-mail", "name", "labs", ""), rows) if rows else "no accounts")
    return 0


def add_account(options: argparse.Namespace) -> int:
    from exogauge.api.passwords import checked, hash_of
    from exogauge.api.session import parsed_email
    from exogauge.jobs.schema import prepare
    from exogauge.settings import Settings
    from exogauge.storage.accounts import Accounts
    from exogauge.storage.store import open_installation

    settings, email = Settings(), parsed_email(options.email)
    name = options.name or email
    password = hash_of(checked(new_secret(), email, name))
    prepare(settings)
    with open_installation(settings).session() as session:
        accounts = Accounts(session)
        account = accounts.add(email, name, password, operator=options.operator)
        lab = None if options.lab is None else accounts.lab_named(options.lab)
        if lab is None:
            lab = accounts.found_lab(options.lab or settings.lab, None if options.lab else settings.lab)
        accounts.join(account.id, lab.id, options.role, "operator", f"{email} as {options.role}, at a terminal")
    print(f"{email} is {options.role} of {lab.name}; from its next start on the server asks who is there")
    return 0


def change_account(options: argparse.Namespace) -> int:
    from exogauge.api.passwords import checked, hash_of
    from exogauge.api.session import parsed_email
    from exogauge.settings import Settings
    from exogauge.storage.accounts import Accounts
    from exogauge.storage.store import open_installation

    email = parsed_email(options.email)
    with open_installation(Settings()).session() as session:
        accounts = Accounts(session)
        account = accounts.by_email(email)
        if options.what == "password":
            accounts.set_password(account.id, hash_of(checked(new_secret(), email, account.name)))
            accounts.end_sessions(account.id)
        else:
            accounts.disable(account.id, options.what == "lock")
    print(f"{email}: {options.what} done")
    return 0


def list_labs(_: argparse.Namespace) -> int:
    from exogauge.settings import Settings
    from exogauge.storage.closing import all_labs
    from exogauge.storage.store import open_installation
    from exogauge.terminal import text_table

    with open_installation(Settings()).reading() as session:
        rows = [
            [each.name, each.id, f"closed {each.closed_at:%Y-%m-%d}" if each.closed_at else ""]
            for each in all_labs(session)
        ]
    print(text_table(("lab", "id", ""), rows) if rows else "no labs")
    return 0


def change_lab(options: argparse.Namespace) -> int:
    from exogauge.errors import NotFound
    from exogauge.settings import Settings
    from exogauge.storage.accounts import Accounts
    from exogauge.storage.closing import close_lab, reopen_lab
    from exogauge.storage.store import open_installation

    with open_installation(Settings()).session() as session:
        if options.what == "reopen":
            reopen_lab(session, options.lab, "operator")
        else:
            found = Accounts(session).lab_named(options.lab)
            if found is None:
                raise NotFound(f"there is no lab {options.lab!a}")
            close_lab(session, found.id, "operator")
    print(f"{options.lab}: {options.what} done")
    return 0


def retract_publication(options: argparse.Namespace) -> int:
    from contextlib import closing

    from exogauge.settings import Settings
    from exogauge.storage.publications import published
    from exogauge.storage.store import open_installation

    with closing(open_installation(Settings())) as installation:
        with installation.reading() as session:
            found = published(session, options.key)
        with installation.of_lab(found.lab_id, "operator").transaction() as store:
            store.publications.revoke(found.id, options.because)
    print(f"{options.key}: revoked; its files are gone, its address tells why")
    return 0


def secret(prompt: str) -> str:
    """Typed unseen, or the first line of what is piped in."""
    return getpass.getpass(prompt) if sys.stdin.isatty() else sys.stdin.readline().rstrip("\n")


def new_secret() -> str:
    from exogauge.errors import BadInput, Fault

    first = secret("New password: ")
    if sys.stdin.isatty() and secret("Once more: ") != first:
        raise BadInput(Fault("the two are not alike", "password_differs", "Type it again."))
    return first
