import type { ReactNode } from 'react';

/** Names with their values, one a line. Rows without a value are left out. */
export function Fields({ rows }: { rows: readonly (readonly [name: string, value: ReactNode])[] }) {
  return (
    <dl className="fields">
      {rows.filter(([, value]) => value !== '' && value !== null && value !== undefined).map(([name, value]) => (
        <div key={name}><dt>{name}</dt><dd>{value}</dd></div>
      ))}
    </dl>
  );
}

/** A part of the inspector that folds; its number stands beside the title. */
export function Section({ title, count, isOpen = true, children }: { title: string; count?: number; isOpen?: boolean; children: ReactNode }) {
  return (
    <details className="section" open={isOpen}>
      <summary><h3>{title}</h3>{count !== undefined && <span className="count">{count}</span>}</summary>
      {children}
    </details>
  );
}
