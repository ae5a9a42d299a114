import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import type { Plugin } from 'vite';

/** Writes third-party-notices.txt: name, version, licence and licence text of every package in the bundle. */
export function thirdPartyNotices(): Plugin {
  return {
    name: 'third-party-notices',
    apply: 'build',
    generateBundle() {
      const roots = new Set<string>();
      for (const id of this.getModuleIds()) {
        const root = packageRoot(id);
        if (root) roots.add(root);
      }
      const notices = [...roots].sort().map(notice);
      this.emitFile({ type: 'asset', fileName: 'third-party-notices.txt', source: notices.join('\n\n') });
    },
  };
}

function packageRoot(id: string): string | null {
  const path = id.replace(/^\0/, '').replace(/\?.*$/, '');
  const at = path.lastIndexOf('/node_modules/');
  if (at < 0) return null;
  let folder = dirname(path);
  while (folder.length > at && !isPackage(folder)) folder = dirname(folder);
  return isPackage(folder) ? folder : null;
}

/** Packages put a bare package.json into subfolders to set the module type; only one with a version is a package. */
function isPackage(folder: string): boolean {
  const file = join(folder, 'package.json');
  return existsSync(file) && 'version' in (JSON.parse(readFileSync(file, 'utf8')) as object);
}

function notice(root: string): string {
  const about = JSON.parse(readFileSync(join(root, 'package.json'), 'utf8')) as Record<string, string>;
  const file = readdirSync(root).find((name) => /^licen[cs]e/i.test(name));
  const text = file ? readFileSync(join(root, file), 'utf8').trim() : '(The package holds no licence text.)';
  return `${about['name']} ${about['version']} (${about['license']})\n${'-'.repeat(72)}\n${text}\n`;
}
