import { Link, NavLink, useLocation } from "react-router";

import { useSession } from "../api/session";
import { AccountMenu } from "./AccountMenu";
import { address } from "./base";
import { SchemeSwitch } from "./SchemeSwitch";
import styles from "./Shell.module.css";

const PLACES = [
  ["/studies", "Studies"],
  ["/robots", "Robots"],
  ["/devices", "Devices"],
  ["/payloads", "Payloads"],
  ["/motions", "Motions"],
  ["/import", "Import"],
  ["/compare", "Compare"],
] as const;

export function Header() {
  const { data: session } = useSession();
  const { pathname } = useLocation();
  const outside = session?.accounts === true && !session.account;
  return (
    <header className={styles.header}>
      <div className={styles.inner}>
        <Link to="/studies" className={styles.name}>
          <img src={address("icon.svg")} alt="" width={28} height={28} />
          exogauge
        </Link>
        {!outside && (
          <nav aria-label="Main" className={styles.nav}>
            <ul className={styles.links}>
              {PLACES.map(([to, name]) => (
                <li key={to}>
                  {to === "/motions" && pathname.startsWith("/plans/") ? (
                    <Link to={to} className={styles.link} aria-current="page">
                      {name}
                    </Link>
                  ) : (
                    <NavLink to={to} className={styles.link}>
                      {name}
                    </NavLink>
                  )}
                </li>
              ))}
            </ul>
          </nav>
        )}
        <div className={styles.switch}>
          <AccountMenu />
          <SchemeSwitch />
        </div>
      </div>
    </header>
  );
}
