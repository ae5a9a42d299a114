import react from '@vitejs/plugin-react';
import { defineConfig } from 'vitest/config';

import { thirdPartyNotices } from './build/notices.ts';

export default defineConfig({
  plugins: [react(), thirdPartyNotices()],
  base: '/',
  build: {
    outDir: '../rtkit/web/static',
    emptyOutDir: true,
    manifest: 'manifest.json',
    // Nothing is inlined as data: the page's policy allows scripts and styles from files only.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: 'es2023',
  },
  server: { proxy: { '/api': process.env['RTKIT_WEB'] ?? 'http://127.0.0.1:8137' } },
  test: { environment: 'jsdom', setupFiles: ['tests/setup.ts'], include: ['tests/**/*.test.{ts,tsx}'] },
});
