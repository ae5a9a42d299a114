import type { ReactNode } from 'react';

import type { System } from '../model/system';
import { clock } from '../parts/numbers';
import type { Link } from '../server/stream';
import { useTexts } from '../texts';

/** Tells that the picture is not live: no server, or managers that the server has lost. */
export function Banner({ link, lostAt, managers, children }: { link: Link; lostAt: number; managers: System['managers']; children?: ReactNode }) {
  const texts = useTexts();
  const gone = [...managers.values()].filter((manager) => manager.state === 'gone');
  const lines = [
    link === 'lost' && texts.link.lost(clock(lostAt)),
    link === 'up' && gone.length > 0 && texts.link.managerGone(gone.map(({ name, why }) => (why ? `${name} (${why.replace(/\.$/, '')})` : name)).join(', ')),
  ].filter((line) => line !== false);
  return <div className="banners" role="alert">{lines.map((line) => <p key={line} className={`banner banner-${link}`}>{line}</p>)}{children}</div>;
}
