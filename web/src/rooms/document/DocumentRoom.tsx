import type { RoomProps } from '../../shell/rooms';
import './document.css';
import { DocumentEditor } from './DocumentEditor';
import { DocumentList } from './DocumentList';

/** System profiles with nothing running: the files there are, or one of them as a diagram. */
export default function DocumentRoom({ view }: RoomProps) {
  return view.of ? <DocumentEditor key={view.of} of={view.of} /> : <DocumentList />;
}
